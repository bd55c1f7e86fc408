"""What the model would leave with one more effect, with all that are missing, or with one fewer: state by state.

`diagnose` stores these, so that a page can switch between them without fitting anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.diagnosis.refits.forecast import forecast_residual
from stiffcal.diagnosis.refits.heldout_error import left_out_residual, residual_without_folds, with_values_of
from stiffcal.diagnosis.refits.refit_values import RefitValue, refit_values
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.measurements.rms import Rms
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Place
from stiffcal.model.summary import EffectAt, Where
from stiffcal.validation.heldout import validation_folds
from stiffcal.validation.validate import rms_of

if TYPE_CHECKING:
    from stiffcal.diagnosis.scans.load_scan import LoadScan

LEADING = 5
"""Candidates that are refitted even where they are rejected."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RefitSummary:
    """The present model refitted with one more effect, with all that are missing, or without one of its own."""

    change: Literal["with", "without", "all"]
    """Whether the effect was added or taken out, or all that are missing were added."""
    effect: str
    """Its name; "" of all."""
    where: Where
    """Its place."""
    heldout_rms: Rms
    """In held-out data, by the scheme of ``validate``."""
    values: list[RefitValue]
    """Of all parameters; empty for a model without one of its effects."""
    added: list[EffectAt] = field(default_factory=list)
    """Of all: which ones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredRefits:
    """The document ``refits`` of a store."""

    schema: Literal["stiffcal/refits/1"] = "stiffcal/refits/1"
    key: str
    """Of the diagnosis that they belong to."""
    entries: list[RefitSummary]
    """In the order of the table ``refits``."""


@dataclass(frozen=True)
class Refit:
    """A refit with its residual."""

    summary: RefitSummary
    residual: Floats
    """(m, n) m and rad, each pose or region by a fit without it, as ``validate`` leaves them out.

    Rows and states are those of the scan's observations.
    """


def refits_of(scan: LoadScan, with_all: LoadScan | None, diagnosis: DiagnoseResult) -> Iterator[Refit]:
    """Refit the present model with each candidate not rejected, with all that is missing, and without each effect.

    Parameters
    ----------
    scan : of the present model.
    with_all : of the model with all that is missing; None where nothing is.
    diagnosis : what is missing.

    Yields
    ------
    Refit
        Linear about the present fit, as the ranking of candidates is; with all that is missing about its own fit.
    """
    data = scan.fit.data
    leading = refitted_candidates(diagnosis)
    places = [(trial.candidate.effect.name, Where.of(trial.candidate.place)) for trial in scan.trials]
    scheme, fold = validation_folds(data)
    validated = diagnosis.as_validated
    if validated is None or validated.scheme != scheme:
        as_validated: Callable[[LoadScan, Trial | None], Floats] = left_out_residual
        fold = scan.fold_of_state
    else:
        as_validated = partial(residual_without_folds, fold=fold)
    if with_all is not None:
        residual = as_validated(with_all, None)
        yield Refit(refit_with_all(diagnosis, Rms.of(rms_of(residual, with_all.fit.data))), residual)
    for trial in (scan.trials[places.index(place)] for place in leading if place in places):
        residual = as_validated(scan, trial)
        candidate, rms = trial.candidate, Rms.of(rms_of(residual, data))
        yield Refit(_summary("with", candidate.effect.name, candidate.place, rms, _values_with(scan, trial)), residual)
    robot: CompliantRobot = scan.fit.robot
    for number, placed in enumerate(robot.placed):
        left = forecast_residual(scan, removed=(number,), fold=fold)
        if left is not None:
            yield Refit(
                _summary("without", placed.effect.name, placed.place, Rms.of(rms_of(left, data)), []), np.asarray(left)
            )


def refitted_candidates(diagnosis: DiagnoseResult) -> list[tuple[str, Where]]:
    """Return the candidates that are refitted: all that the diagnosis names, the leading ones, and the possible ones.

    Parameters
    ----------
    diagnosis : the result of the search.
    """
    leading = [
        finding for rank, finding in enumerate(diagnosis.findings) if rank < LEADING or finding.verdict != "rejected"
    ]
    named = [
        *((entry.effect, entry.where) for entry in leading),
        *((entry.effect, entry.where) for entry in diagnosis.missing),
        *((alike.effect, alike.where) for entry in diagnosis.missing for alike in entry.alternatives),
        *((entry.effect, entry.where) for entry in diagnosis.undecided),
        *((entry.effect, entry.where) for entry in diagnosis.could_be),
    ]
    return [place for number, place in enumerate(named) if place not in named[:number]]


def refit_with_all(diagnosis: DiagnoseResult, rms: Rms) -> RefitSummary:
    """Return the summary of the model with all that is missing.

    Parameters
    ----------
    diagnosis : the result of the search.
    rms : the error in held-out data of the model with all that is missing.
    """
    return RefitSummary(
        change="all",
        effect="",
        where=Where(),
        heldout_rms=rms,
        values=[
            RefitValue(
                name=parameter.name, value=parameter.value, interval=parameter.interval, at_bound=parameter.at_bound
            )
            for parameter in diagnosis.parameters_with_missing
        ],
        added=[EffectAt(effect=missing.effect, where=missing.where) for missing in diagnosis.missing],
    )


def _values_with(scan: LoadScan, trial: Trial) -> list[RefitValue]:
    """Return the values with a candidate, with the intervals of what the linear refit determines."""
    robot, fit = with_values_of(scan, trial), scan.fit
    own = [fit.robot.placed[column.placed].parameter_name(column.symbol) for column in fit.columns]
    return refit_values(robot, scan, trial, own)


def _summary(
    change: Literal["with", "without"], effect: str, place: Place, rms: Rms, values: list[RefitValue]
) -> RefitSummary:
    return RefitSummary(change=change, effect=effect, where=Where.of(place), heldout_rms=rms, values=values)
