"""What the model would leave with one more effect, or with one fewer: refitted, state by state.

`diagnose` stores these, so that a page can switch between them without fitting anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.evidence import refitted_without
from stiffcal.diagnosis.heldout_error import left_out_residual, with_values_of
from stiffcal.diagnosis.results import Finding
from stiffcal.documents import Number
from stiffcal.measurements.rms import Rms
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import Place
from stiffcal.model.summary import Where
from stiffcal.validation.validate import rms_of

if TYPE_CHECKING:
    from stiffcal.diagnosis.load_scan import LoadScan

MOST_CANDIDATES = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class RefitValue:
    """A parameter's value in a refit."""

    name: str
    """``effect.place.symbol``."""
    value: Number
    """SI; null where it is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RefitSummary:
    """The present model refitted with one more effect, or without one of its own."""

    change: Literal["with", "without"]
    """Whether the effect was added or taken out."""
    effect: str
    """Its name."""
    where: Where
    """Its place."""
    heldout_rms: Rms
    """In poses left out of the fit."""
    values: list[RefitValue]
    """Of all parameters; empty for a model without one of its effects."""


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
    """(m, n) m and rad, each pose by a fit without it; rows and states of the scan's observations."""


def refits_of(scan: LoadScan, findings: Sequence[Finding]) -> Iterator[Refit]:
    """Refit the present model with each of the leading candidates, and without each of its own effects.

    Parameters
    ----------
    scan : of the present model.
    findings : the ranking, best first.

    Yields
    ------
    Refit
        Linear about the present fit, as the ranking of candidates is.
    """
    data = scan.fit.data
    leading = [(finding.effect, finding.where) for finding in findings[:MOST_CANDIDATES]]
    places = [(trial.candidate.effect.name, Where.of(trial.candidate.place)) for trial in scan.trials]
    for trial in (scan.trials[places.index(place)] for place in leading if place in places):
        residual = left_out_residual(scan, trial)
        values = [
            RefitValue(name=name, value=float(value)) for name, value in with_values_of(scan, trial).values().items()
        ]
        yield Refit(
            _summary(
                "with", trial.candidate.effect.name, trial.candidate.place, Rms.of(rms_of(residual, data)), values
            ),
            residual,
        )
    robot: CompliantRobot = scan.fit.robot
    for number, placed in enumerate(robot.placed):
        left = refitted_without(scan, number)
        if left is not None:
            yield Refit(
                _summary("without", placed.effect.name, placed.place, Rms.of(rms_of(left, data)), []), np.asarray(left)
            )


def _summary(
    change: Literal["with", "without"], effect: str, place: Place, rms: Rms, values: list[RefitValue]
) -> RefitSummary:
    return RefitSummary(change=change, effect=effect, where=Where.of(place), heldout_rms=rms, values=values)
