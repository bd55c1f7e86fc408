"""Which step follows: decided here alone, from what is known of a campaign.

The steps have one order, and an answer leads to a later one: who follows the advice comes to an end.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.outcome import DiagnosisOutcome
    from stiffcal.diagnosis.answers.results import DiagnoseResult
    from stiffcal.measurements.rms import Rms


class Step(Enum):
    """The steps of the loop, in their order; the values are the commands."""

    CHECK = "check"
    IDENTIFY = "identify"
    VALIDATE = "validate"
    DIAGNOSE = "diagnose"
    IMPROVE = "improve"
    NEW_EFFECT = "effects"
    REPORT = "report"
    VIEW = "view"
    EXPORT = "export"


ORDER = tuple(Step)


@dataclass(frozen=True, slots=True)
class Standing:
    """What is known of a campaign and its present model."""

    logs_missing: bool
    """Whether logs are not there yet, and no fit was made without them."""
    is_fitted: bool
    """Whether the last fit is of the present model."""
    heldout_rms: Rms | None = None
    """Its error in held-out data; None until it is validated."""
    noise: Rms | None = None
    """In the same measure; None where it is not known."""
    diagnosis: DiagnoseResult | DiagnosisOutcome | None = None
    """Of that fit; None until it is diagnosed."""
    untested: str | None = None
    """Name of the effect that would test the pattern which the diagnosis found; None where none is left to test."""
    is_ingested: bool = True
    """Whether its logs have been read and accepted before."""
    has_effects: bool = True
    """Whether its model has any effect."""


def next_step(standing: Standing, after: Step | None, done: Collection[Step] = ()) -> Step | None:
    """Return the first step after the one that has answered which the campaign calls for; None after the last.

    Parameters
    ----------
    standing : of the campaign, after that answer.
    after : the step that has answered; None of a command that is no step of the loop, as `history` and `add`.
    done : steps whose files that command has written too.
    """
    following = ORDER if after is None else ORDER[ORDER.index(after) + 1 :]
    return next((step for step in following if step not in done and _is_called_for(step, standing)), None)


def _is_called_for(step: Step, standing: Standing) -> bool:
    diagnosis = standing.diagnosis
    match step:
        case Step.CHECK:
            return standing.logs_missing or not (standing.is_fitted or standing.is_ingested)
        case Step.IDENTIFY:
            return not standing.is_fitted
        case Step.VALIDATE:
            return standing.heldout_rms is None
        case Step.DIAGNOSE:
            return diagnosis is None and not is_within_noise(standing.heldout_rms, standing.noise)
        case Step.IMPROVE:
            return diagnosis is not None and bool(diagnosis.missing)
        case Step.NEW_EFFECT:
            return standing.untested is not None
        case Step.REPORT | Step.VIEW | Step.EXPORT:
            return True


def is_within_noise(rms: Rms | None, known_noise: Rms | None) -> bool:
    """Return whether every measure of an error is known to be no larger than the noise allows."""
    from stiffcal.diagnosis.thresholds import ADEQUATE_RATIO

    noise = {} if known_noise is None else dict(known_noise.items())
    errors = {} if rms is None else {name: value for name, value in rms.items() if value is not None}
    adequate = [value <= ADEQUATE_RATIO * (noise.get(name) or 0.0) for name, value in errors.items()]
    return bool(adequate) and all(adequate)
