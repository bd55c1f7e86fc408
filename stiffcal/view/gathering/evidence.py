"""What the diagnosis reads of effects that are missing or were added: what they follow, and how they act."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.columns import values_of
from stiffcal.stages.diagnoses.stored_curves import EVIDENCE
from stiffcal.stages.steps import Ingested
from stiffcal.view.content import ViewEvidence, ViewVariable
from stiffcal.view.gathering.models import place_words

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult

_AXES = ("along_x", "along_y", "along_z")
_UNITS = {"rad": (180.0 / np.pi, "°"), "1": (1.0, "")}


def view_evidence(
    data: Ingested,
    diagnosis: DiagnoseResult | None,
    variables: Sequence[ViewVariable],
    added_last: Collection[str] = (),
    present: Collection[str] = (),
    of_present: bool = True,
) -> tuple[list[ViewEvidence], list[ViewVariable]]:
    """Return the effects that are missing or were added last, and the variables that only they follow.

    Parameters
    ----------
    data : the campaign with its states. diagnosis : of a fit to these states; None without one.
    variables : what residuals may follow, over all states.
    added_last : ``effect place`` of those that the present model holds and the fit before did not.
    present : ``effect place`` of all that it holds: what was missing when it was diagnosed may be among them.
    of_present : whether the diagnosis is of the present fit: what it finds missing still is.

    Returns
    -------
    evidence : over all n states; empty where an older store holds no directions.
    added : variables that are not among ``variables`` yet.
    """
    if diagnosis is None or not diagnosis.evidence or EVIDENCE not in data.store.tables:
        return [], []
    table = data.store.read_table(EVIDENCE)
    if not {*_AXES} <= {*table.column_names}:
        return [], []
    entry, state, driver = (np.asarray(values_of(table.column(name))) for name in ("entry", "state", "driver"))
    along = np.stack([np.asarray(values_of(table.column(name)), dtype=np.float64) for name in _AXES], axis=1)
    named = {variable.label: variable.name for variable in variables}
    found: list[ViewEvidence] = []
    added: list[ViewVariable] = []
    for number, summary in enumerate(diagnosis.evidence):
        name = f"{summary.effect} {place_words(summary.where)}"
        is_missing = summary.status == "missing" and of_present
        if not is_missing and name not in added_last:
            continue
        rows = entry == number
        direction = _scattered(along[rows], state[rows], len(data.states))
        if not np.isfinite(direction).any():
            continue
        if summary.driver not in named:
            factor, unit = _UNITS.get(summary.unit, (1.0, summary.unit))
            values = factor * _scattered(driver[rows], state[rows], len(data.states))
            named[summary.driver] = f"driver{number + 1}"
            added.append(ViewVariable(name=named[summary.driver], label=summary.driver, unit=unit, values=values))
        found.append(
            ViewEvidence(
                name=name,
                standing="missing" if is_missing and name not in present else "added",
                variable=named[summary.driver],
                turns=summary.component == "rotation",
                along=direction,
            )
        )
    return found, added


def _scattered(values: Floats, state: Integers, n: int) -> Floats:
    """Return (n, …) of values at some states; NaN at all others."""
    whole = np.full((n, *values.shape[1:]), np.nan)
    whole[state] = values
    return whole


def picked_evidence(evidence: ViewEvidence, pick: Integers) -> ViewEvidence:
    """Return the evidence over the states that are drawn."""
    return replace(evidence, along=evidence.along[pick])
