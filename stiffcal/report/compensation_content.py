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
    """(n, 3) N, less the reference's."""
    displacement: Floats
    """(n, 3) m, NaN where not measured: observed, the controller's own motion with it."""
    rotation: Floats
    """(n, 3) rad, likewise."""


@dataclass(frozen=True)
class ComparedPose:
    """A pose measured twice."""

    pose: str
    """Joint angles in words."""
    off: HalfRun
    """The run without compensation."""
    on: HalfRun
    """The run with compensation."""
    error_off: tuple[float, float]
    """(m, rad) rms error over the loaded states without compensation; rad is NaN where not measured."""
    error_on: tuple[float, float]
    """The same with compensation."""
    largest_off: tuple[float, float]
    """(m, rad) largest error of a state without compensation; rad is NaN where not measured."""
    largest_on: tuple[float, float]
    """The same with compensation."""

    @property
    def gone(self) -> float:
        """The share of the position error that the compensation takes away."""
        return 1.0 - self.error_on[0] / self.error_off[0]


@dataclass(frozen=True)
class Trace:
    """A run over time."""

    name: str
    """The run's id."""
    time: Floats
    """(n,) s since the load came."""
    wrench: Floats
    """(n, 6) N, N·m, as the sensor read it."""
    displacement: Floats
    """(n,) m."""


@dataclass(frozen=True)
class TimePair:
    """Two runs over time in one pose."""

    kind: str
    """"step" for a load that comes at once, "process" for a machining process."""
    off: Trace
    """The run without compensation."""
    on: Trace
    """The run with compensation."""
    delay: float
    """s from the load until half of its displacement is taken back; NaN where it never is."""
    remaining: float
    """m, what remains of the displacement when the correction stands."""
    uncorrected: float
    """m, the displacement without the correction."""


@dataclass(frozen=True)
class WithAndWithout:
    """All pairs of a campaign."""

    poses: tuple[ComparedPose, ...]
    """The poses measured twice."""
    over_time: tuple[TimePair, ...] = ()
    """The pairs of runs over time."""
    played: str = ""
    """Of a simulated campaign, what its delay is made of and what is left out; "" for a measured one."""
