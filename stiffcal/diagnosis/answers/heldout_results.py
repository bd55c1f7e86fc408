"""Errors in held-out data that a diagnosis states next to those of its search."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.documents import Number
from stiffcal.measurements.rms import Rms


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorInExperiment:
    """What an effect does to the held-out error of one kind of experiment."""

    experiment: str
    """The kind."""
    before: Number
    """Rms without it: m, rad of clamped runs; null where nothing of the kind was read."""
    after: Number
    """Rms with it."""
    n_fell: int
    """In how many of what is left out in turn (poses, positions, cycles) the error falls."""
    n_folds: int
    """Of how many."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorAsValidated:
    """The error of the present model as ``validate`` states it, where that leaves out other data than the search."""

    scheme: str
    """What ``validate`` leaves out: "poses-region", regions of the joints' ranges in turn; or the "holdout" runs."""
    rms: Rms
    """Of the present model."""
    with_missing: Rms | None
    """With what is missing; null where nothing is."""
