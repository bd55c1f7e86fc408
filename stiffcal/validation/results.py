"""What ``validate`` answers of load states: the error in parts of the data, and the verdict on thresholds; SI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from stiffcal.documents import NOT_PROMISED, Number, OrAbsent
from stiffcal.measurements.rms import Rms

SliceBy: TypeAlias = Literal["run", "direction", "load", "branch", "joint_angle", "body", "joint", "experiment"]
"""What the data are cut into slices by."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorSlice:
    """The error in a part of the data."""

    label: str
    """What part, in words."""
    low: Number
    """Least value of what the data are cut by, SI; None where the part has no range."""
    high: Number
    """Greatest value."""
    n: int
    """States, or readings of other experiments."""
    rms: Rms
    """Of the residual."""
    max: Rms
    """The largest residual, in the same measures."""
    zero_model: OrAbsent[Rms] = None
    """What a model without parameters leaves; None where that is not asked for."""
    joint: OrAbsent[int] = None
    """The joint by whose angle the data are cut, from 1; None of other parts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorstState:
    """A state with a large residual."""

    run: str
    """The run's name."""
    row: int
    """Data row of the states table from 1, or the hold's number in the run."""
    residual_m: Number
    """Length of the translation residual, m; null where none was measured."""
    residual_rad: OrAbsent[float] = None
    """Of a clamped run: residual of the motor's angle at the joint's side, rad."""
    load: Annotated[Number, NOT_PROMISED]
    """Size of the load, N (N·m where no force was applied)."""
    branch: Annotated[str, NOT_PROMISED]
    """"unloaded", "loading", "peak" or "unloading"."""


@dataclass(frozen=True, slots=True)
class ThresholdCheck:
    """One threshold, judged."""

    threshold: str
    """Its key."""
    where: str
    """The joint's name, "" for the whole campaign."""
    limit: float
    """In `unit`."""
    value: Number
    """In `unit`; None where it is not known."""
    unit: str
    """Of `limit` and `value`."""
    held: bool | None
    """None where it cannot be judged."""
    says: str
    """The result in words."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What came of all thresholds of a campaign."""

    checks: list[ThresholdCheck]
    """One for each threshold and joint."""
    thresholds: dict[str, object]
    """What was asked for, as campaign.toml writes it."""

    @property
    def failed(self) -> list[str]:
        """The checks that do not hold, in words."""
        return [check.says for check in self.checks if check.held is False]

    @property
    def not_judged(self) -> list[str]:
        """The checks that cannot be judged, in words."""
        return [check.says for check in self.checks if check.held is None]

    @property
    def passed(self) -> bool:
        """Whether no check fails."""
        return not self.failed
