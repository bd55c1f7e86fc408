"""The residual against what it follows, as `diagnose` found it: the points of one picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.pattern_results import CompliancePattern, FollowedBy
from stiffcal.measurements.columns import values_of
from stiffcal.measurements.varying import varies
from stiffcal.quantity import COMPLIANCE, FORCE, JOINT_ANGLE, MOMENT, of_measure
from stiffcal.stages.diagnoses.stored_curves import EVIDENCE
from stiffcal.stages.steps import Ingested, RunContext, up_to_date_states

if TYPE_CHECKING:
    from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect

FEWEST_POINTS = 3
"""Of fewer no course can be seen: a line goes through two."""


@dataclass(frozen=True)
class FollowedResidual:
    """Points of a residual over something that it follows, in the units in which people read them."""

    of: str
    """What is drawn: "held-out residual along backlash"."""
    unit: str
    """Of `y`: mm, mrad, N·m …."""
    follows: str
    """What it is drawn over: "torque on joint 4"."""
    follows_unit: str
    """Of `x`; "" for a number."""
    x: Floats
    """(n,) what it follows."""
    y: Floats
    """(n,) what is drawn; a residual is in held-out data, without the effect that is missing."""


def followed_residual(folder: Path, diagnosis: DiagnoseResult, context: RunContext) -> FollowedResidual | None:
    """Return the residual over what it follows; None where the diagnosis found nothing to show.

    Of the first effect that is missing it is what that one accounts for; where nothing in the catalogue does, a joint's
    apparent change of compliance, run by run.

    Parameters
    ----------
    folder : the campaign folder. diagnosis : of its present fit, as `diagnose_campaign` returns it.
    context : store and so on.
    """
    found = None
    if diagnosis.missing:
        data = up_to_date_states(folder, context)
        found = _of_states(data, diagnosis) or _of_rows(data, diagnosis.missing[0], context)
    elif diagnosis.pattern is not None:
        found = _of_pattern(diagnosis.pattern)
    if found is None or np.count_nonzero(np.isfinite(found.x + found.y)) < FEWEST_POINTS or not varies(found.x):
        return None
    return found


def _of_states(data: Ingested, diagnosis: DiagnoseResult) -> FollowedResidual | None:
    """Return the evidence of the first missing effect that has any."""
    named = [(effect.effect, effect.where) for effect in diagnosis.missing]
    number = next(
        (
            number
            for number, entry in enumerate(diagnosis.evidence)
            if entry.status == "missing" and (entry.effect, entry.where) in named
        ),
        None,
    )
    if number is None or EVIDENCE not in data.store.tables:
        return None
    table, summary = data.store.read_table(EVIDENCE), diagnosis.evidence[number]
    rows = np.asarray(values_of(table.column("entry"))) == number
    x, y = (np.asarray(values_of(table.column(name)), dtype=np.float64)[rows] for name in ("driver", "before"))
    x, unit = _read(x, summary.unit)
    residual = of_measure(summary.component).unit_for([float(np.nanmax(np.abs(y), initial=0.0))])
    return FollowedResidual(
        f"held-out residual along {summary.effect}", residual.name, summary.driver, unit, x, residual.factor * y
    )


def _of_rows(data: Ingested, missing: ProposedEffect, context: RunContext) -> FollowedResidual | None:
    """Return what is left of the rows of another experiment over what drives an effect of its joint."""
    from stiffcal.kinds import all_kinds
    from stiffcal.model.catalogue.campaign_effects import effects_with
    from stiffcal.stages.experiments import runs_with_fits
    from stiffcal.stages.validation import up_to_date_results

    if not missing.where.joints:
        return None
    identified, _ = up_to_date_results(data, context)
    effect, measured = effects_with(data.campaign, missing.effect)[missing.effect], runs_with_fits(data)
    for kind in all_kinds():
        rows, driver = kind.drawn_rows(measured, identified), kind.driver(measured, effect, missing.where.joints[0])
        if rows is None or driver is None or rows.heldout_table not in data.store.tables:
            continue
        residual: Any = values_of(data.store.read_table(rows.heldout_table).column(rows.residual))
        if len(residual) != np.count_nonzero(rows.judged):
            continue  # of an earlier model
        y = np.full(len(rows.measured), np.nan)
        y[rows.judged] = residual
        return FollowedResidual("held-out residual", MOMENT.usual.name, driver.label, driver.unit, driver.values, y)
    return None


def _of_pattern(pattern: CompliancePattern) -> FollowedResidual:
    """Return a joint's apparent change of compliance in each run, over what it follows."""
    of = pattern.of_joint
    follows, unit, factor = {
        FollowedBy.JOINT_ANGLE: (f"angle of joint {of}", JOINT_ANGLE.usual.name, JOINT_ANGLE.usual.factor),
        FollowedBy.JOINT_TORQUE: (f"size of the torque on joint {of}", MOMENT.usual.name, pattern.scale),
        FollowedBy.LOAD: ("size of the load", FORCE.usual.name, pattern.scale),
        FollowedBy.TIME: ("time", "s", pattern.scale),
        FollowedBy.LAST_MOTION: (f"last motion of joint {of}: 1 with its torque, −1 against it", "", 1.0),
    }[pattern.follows]
    x = factor * np.array([point.at for point in pattern.points])
    compliance = [point.compliance for point in pattern.points]
    shown = COMPLIANCE.unit_for(compliance)
    y = shown.factor * np.array(compliance)
    return FollowedResidual(f"apparent change of compliance of joint {pattern.joint}", shown.name, follows, unit, x, y)


def _read(values: Floats, unit: str) -> tuple[Floats, str]:
    """Return a covariate as people read it: angles in degrees."""
    angle = JOINT_ANGLE.usual
    return (angle.factor * values, angle.name) if unit == "rad" else (values, "" if unit == "1" else unit)
