"""What the report shows of runs with the controller correcting beside the same poses without: finished arrays."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class HalfRun:
    """One of two runs in one pose, since its unloaded reference; base axes.

    Attributes
    ----------
    name : the run's id.
    force : (n, 3) N, less the reference's. moved : (n, 3) m, turned : (n, 3) rad, NaN where not measured: as seen, the
        controller's own motion with it.
    """

    name: str
    force: Floats
    moved: Floats
    turned: Floats


@dataclass(frozen=True)
class ComparedPose:
    """A pose measured twice; ``error``: rms over the loaded states, ``largest``: of one of them: (position, rotation).

    Attributes
    ----------
    pose : joint angles in words.
    off, on : without and with compensation.
    error_off, error_on, largest_off, largest_on : m and rad; rad NaN where not measured.
    """

    pose: str
    off: HalfRun
    on: HalfRun
    error_off: tuple[float, float]
    error_on: tuple[float, float]
    largest_off: tuple[float, float]
    largest_on: tuple[float, float]

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
    moved: Floats


@dataclass(frozen=True)
class TimePair:
    """Two runs over time in one pose.

    Attributes
    ----------
    kind : "step" for a load that comes at once, "process" for a machining process.
    off, on : without and with compensation.
    delay : s from the load until half of what it moved is taken back; NaN where it never is.
    left : m, what remains of the displacement when the correction stands. given : m, what the load makes without it.
    """

    kind: str
    off: Trace
    on: Trace
    delay: float
    left: float
    given: float


@dataclass(frozen=True)
class WithAndWithout:
    """All pairs of a campaign.

    Attributes
    ----------
    poses, over_time : the pairs.
    played : of a simulated campaign, what its delay is made of and what is left out; "" for a measured one.
    """

    poses: tuple[ComparedPose, ...]
    over_time: tuple[TimePair, ...] = ()
    played: str = ""
