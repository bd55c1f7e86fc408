"""The fits of a campaign: as the store keeps them, and as `history` answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.documents import NOT_IN_DOCUMENT, NOT_PROMISED, CommandResult, OrAbsent, Origin
from stiffcal.identification.answers.before_after import EstimatedParameter
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import EffectAt, ModelSummary


@dataclass(frozen=True, slots=True, kw_only=True)
class HistoryEntry:
    """A fit of the campaign."""

    id: str
    """Its name."""
    time: str
    """UTC, ISO 8601."""
    model: ModelSummary
    """The model that was fitted."""
    heldout_rms: Rms | None
    """The error in held-out data, as ``validate`` states it; null until it is validated."""
    scheme: OrAbsent[str] = None
    """How data were left out, as in ``validate``: "leave-one-pose-out", "poses-region" of absolute poses …; None until
    it is validated.
    """
    fit_rms: Rms
    """Of the residuals."""
    noise: Rms | None
    """What the instruments scatter, in the same measure; null where it is not known."""
    loss: Annotated[Literal["linear", "huber"] | None, NOT_PROMISED] = None
    """Of the least squares."""
    likely: OrAbsent[list[EffectAt]] = None
    """Effects that `improve` added in this step though they were probable and not certain."""
    origin: OrAbsent[Origin] = None
    """From whom it comes."""
    model_text: Annotated[str, NOT_IN_DOCUMENT] = ""
    """The model file of that fit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HistoryResult(CommandResult):
    """Answer of ``history``."""

    schema: Literal["stiffcal/history/1"] = "stiffcal/history/1"
    fits: list[HistoryEntry]
    """Oldest first."""
    not_fitted_yet: OrAbsent[ModelSummary] = None
    """The present model where that is not the last one fitted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredFit:
    """A fit as the store keeps it, with the text of its model file."""

    id: str
    time: str
    model: ModelSummary
    heldout_rms: Rms | None
    scheme: OrAbsent[str] = None
    """How data were left out; None until it is validated."""
    fit_rms: Rms
    noise: Rms | None
    loss: Literal["linear", "huber"]
    key: str
    """A hash of all that went into it."""
    model_text: str
    """The model file, "" where there was none."""
    parameters: list[EstimatedParameter]
    """The identified values."""
    states_key: str
    """A hash of the load states."""
    likely: OrAbsent[list[EffectAt]] = None
    """Effects that `improve` added in this step though they were probable and not certain."""
    origin: OrAbsent[Origin] = None
