"""One friction run's logs on one clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from stiffcal.arrays import Booleans, Floats
from stiffcal.measurements.load_states import RunInfo
from stiffcal.reduction.clocks.offsets import SourceClockOffset


@dataclass(frozen=True)
class FrictionRun:
    """One run's logs at the joint's side, on one clock."""

    info: RunInfo
    """The run as the manifest describes it."""
    moved_joint: int | None
    """From 1; None where the logs have to show it."""
    time: Floats
    """(n,) s."""
    angle: Floats
    """(n, J) rad."""
    torque: Floats
    """(n, J) N·m."""
    velocity: Floats | None
    """(n, J) rad/s as logged, or None."""
    temperature: Floats | None = None
    """(n,) K, the first logged one; None where none is logged, or on a clock that nothing ties to the angles'."""
    clocks: Mapping[str, SourceClockOffset] = field(default_factory=dict)
    """Source to how much its clock shows more than the first source's."""
    excluded: Booleans | None = None
    """(n,) True where angle or torque is interpolated over rows that the manifest excludes; None where none is."""
