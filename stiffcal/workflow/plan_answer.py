"""What a plan answers: its runs in order, what each parameter's uncertainty would be, what more runs bring."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.uncertainty import NORMAL_95
from stiffcal.workflow.plan_candidates import Candidates
from stiffcal.workflow.plan_model import PlanModel

# χ² by which a model must fit better for a test of two to decide: five standard deviations.
ENOUGH = 25.0

if TYPE_CHECKING:
    from stiffcal.planning.choice import Choice
    from stiffcal.planning.expected import ExpectedFit
    from stiffcal.planning.information import RunInformation
    from stiffcal.planning.results import ExpectedParameter, GainPoint, LossOfRun, RunToMeasure, Separation
    from stiffcal.planning.rivals import PairInformation
    from stiffcal.workflow.plan_rivals import NamedRival


def tolerances(campaign: Campaign) -> Floats:
    """Return (6 J,) the standard deviations of the geometry, m and rad, as robot.toml states them or by default."""
    from stiffcal.identification.geometry_prior import GeometryPrior, GeometrySource

    tolerance = campaign.chain.tolerance
    prior = GeometryPrior(tolerance.length, tolerance.angle, GeometrySource.DEFAULT)
    return prior.sizes(campaign.chain.n_joints)


def losses_of_runs(
    choice: Choice, expected: ExpectedFit, names: tuple[str, ...], runs: list[RunToMeasure]
) -> list[LossOfRun]:
    """Return the identified parameters of which one run brings more than half of the information, with that run."""
    from stiffcal.planning.choice import LARGEST_RELATIVE
    from stiffcal.planning.results import LossOfRun

    ids = {run.rank: run.id for run in runs}
    places = np.flatnonzero(choice.free)
    losses = []
    for column, place in enumerate(places):
        after = float(expected.course[-1, column])
        rank = int(np.argmax(expected.without[:, column]))
        lost = float(expected.without[rank, column])
        if choice.identified[place] and after <= LARGEST_RELATIVE and lost**2 > 2.0 * after**2:
            relative = NORMAL_95 * lost if lost <= LARGEST_RELATIVE else None
            losses.append(LossOfRun(parameter=names[place], run=ids[rank + 1], relative=relative))
    return losses


def expected_parameters(
    model: PlanModel, information: RunInformation, choice: Choice, fit: ExpectedFit
) -> list[ExpectedParameter]:
    """Return the parameters with their expected uncertainties."""
    from stiffcal.planning.choice import LARGEST_RELATIVE
    from stiffcal.planning.results import ExpectedParameter

    specs = {
        placed_effect.parameter_name(spec.symbol): (spec, placed_effect)
        for placed_effect in model.robot.placed
        for spec in placed_effect.effect.parameters
    }
    relative = np.full(len(information.names), np.nan)
    relative[choice.free] = fit.course[-1]
    geometry = np.zeros(len(information.names))
    geometry[choice.free] = fit.from_geometry
    known = choice.identified & (relative <= LARGEST_RELATIVE)
    expected = []
    for k, name in enumerate(information.names):
        spec, placed_effect = specs[name]
        value = placed_effect.values.get(spec.symbol, spec.neutral)
        size = abs(value) if spec.inverse else information.scale[k]
        half = NORMAL_95 * float(relative[k])
        expected.append(
            ExpectedParameter(
                name=name,
                unit=spec.unit,
                value=float(value),
                assumed=name in model.assumed,
                half_width=half * float(size) if known[k] else None,
                relative=half if known[k] else None,
                from_geometry=float(geometry[k]) if known[k] else None,
                identified=bool(known[k]),
            )
        )
    return expected


def runs_to_measure(candidates: Candidates, choice: Choice, minutes: float) -> list[RunToMeasure]:
    """Return the chosen runs in an order of short moves."""
    from stiffcal.planning.choice import short_order
    from stiffcal.planning.results import RunToMeasure

    chosen = choice.design.chosen
    order = short_order(candidates.joints[chosen])
    width = len(str(len(chosen)))
    return [
        RunToMeasure(
            id=f"run{number:0{max(2, width)}d}",
            joints=candidates.joints[chosen[rank]],
            wrench=candidates.wrench[chosen[rank]],
            minutes=minutes,
            approach=np.zeros((0, candidates.joints.shape[1])),
            rank=int(rank) + 1,
        )
        for number, rank in enumerate(order, start=1)
    ]


def gain_of(choice: Choice, expected: ExpectedFit, warm_up: float, minutes: float) -> list[GainPoint]:
    """Return what the first 1, 2, … runs bring, those of highest rank first."""
    from stiffcal.planning.choice import LARGEST_RELATIVE
    from stiffcal.planning.results import GainPoint

    course = expected.course
    worst = np.max(course[:, choice.identified[choice.free] & (course[-1] <= LARGEST_RELATIVE)], axis=1, initial=0.0)
    return [
        GainPoint(
            runs=number,
            minutes=warm_up + number * minutes,
            worst_relative=NORMAL_95 * float(size) if size <= LARGEST_RELATIVE else None,
        )
        for number, size in enumerate(worst, start=1)
    ]


def warnings_of(model: PlanModel) -> list[str]:
    """Return what a reader of the plan must know of its values."""
    warnings = []
    if model.assumed:
        warnings.append(f"{len(model.assumed)} parameters have typical values: expected uncertainties are as rough")
    return warnings


def separations_of(pairs: list[PairInformation], choice: Choice, named: list[NamedRival]) -> list[Separation]:
    """Return how far the chosen runs separate every ordered pair of rival models."""
    from stiffcal.planning.results import Separation

    separations = []
    for pair in pairs:
        size = pair.separation(choice.design.chosen)
        separations.append(
            Separation(
                truth=named[pair.truth].label,
                rival=named[pair.rival].label,
                chi_square=size,
                distinguished=size >= ENOUGH,
            )
        )
    return separations
