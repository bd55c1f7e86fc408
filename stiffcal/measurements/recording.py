"""A recording: one device's log of one run, in SI units, as arrays over time."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class Recording:
    """The samples of one source in one run, on the device's own clock."""

    source: str
    """The source's name in the manifest."""
    run: str
    """The run's id."""
    time: Floats
    """(n,) s on this device's clock, strictly increasing."""
    signals: dict[str, Floats]
    """Signal name ("wrench", "joints", "position", "quaternion", "lengths", "temperature", "hold", …) to (n, c) array:
    wrench (n, 6) N, N·m in sensor axes, as it acts on the robot; joints (n, L) rad; position (n, 3) m and quaternion
    (n, 4) w x y z in the tracker's axes; deflection (n, 6) m, rad.
    """
    file: str
    """Where it was read from, as in the manifest."""
