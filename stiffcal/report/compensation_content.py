"""What the report shows of runs with the controller correcting and of the same poses without: finished arrays."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class HalfRun:
    """One of two runs in one pose, since its unloaded reference; base axes."""

    name: str
    """The run's id."""
    force: Floats
    """(n, 3) N, less the reference's. ``moved``: (n, 3) m, ``turned``: (n, 3) rad, NaN where not measured: observed,
    the controller's own motion with it.
    """
    displacement: Floats
    rotation: Floats


@dataclass(frozen=True)
class ComparedPose:
    """A pose measured twice."""

    pose: str
    """Joint angles in words."""
    off: HalfRun
    on: HalfRun
    """``off``, ``on``: without and with compensation."""
    error_off: tuple[float, float]
    error_on: tuple[float, float]
    largest_off: tuple[float, float]
    largest_on: tuple[float, float]
    """Position (m) and rotation (rad, NaN where not measured): ``error_off``, ``error_on`` the rms over the loaded
    states, ``largest_off``, ``largest_on`` of one of them.
    """

    @property
    def gone(self) -> float:
        """The share of the position error that the compensation takes away."""
        return 1.0 - self.error_on[0] / self.error_off[0]


@dataclass(frozen=True)
class Trace:
    """A run over time: time (n,) s since the load came, wrench (n, 6) as the sensor read it, moved (n,) m."""

    name: str
    time: Floats
    wrench: Floats
    displacement: Floats


@dataclass(frozen=True)
class TimePair:
    """Two runs over time in one pose."""

    kind: str
    """"step" for a load that comes at once, "process" for a machining process."""
    off: Trace
    on: Trace
    """``off``, ``on``: without and with compensation."""
    delay: float
    """S from the load until half of what it moved is taken back; NaN where it never is."""
    remaining: float
    """m, what remains of the displacement when the correction stands. ``given``: m, what the load makes without it."""
    uncorrected: float


@dataclass(frozen=True)
class WithAndWithout:
    """All pairs of a campaign."""

    poses: tuple[ComparedPose, ...]
    over_time: tuple[TimePair, ...] = ()
    """``poses``, ``over_time``: the pairs."""
    played: str = ""
    """Of a simulated campaign, what its delay is made of and what is left out; "" for a measured one."""
