"""What a plan answers: its runs in order, what each parameter's uncertainty would be, what more runs bring."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.planning.campaign.choice import ChosenRuns, Purpose, named_parameters
from stiffcal.planning.campaign.goals import LOOK_ALIKES
from stiffcal.planning.campaign.model import PlanModel
from stiffcal.planning.campaign.pairs import Candidates
from stiffcal.planning.campaign.tracker import tracker_warnings
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import significant

# One-sided 95 % of the normal distribution.
ONE_SIDED = 1.645
# How often each run is repeated at most where a plan does not separate two models.
MOST_TIMES = 20
HOUR = 60.0
NUMBERED = re.compile(r"run([0-9]{1,6})")

if TYPE_CHECKING:
    from stiffcal.identification.answers.observability import ObservabilityIndices
    from stiffcal.planning.campaign.rivals import NamedRival
    from stiffcal.planning.choice import Choice
    from stiffcal.planning.expected import ExpectedFit
    from stiffcal.planning.information import RunInformation
    from stiffcal.planning.results import (
        AnotherHour,
        ExpectedParameter,
        GainPoint,
        LossOfRun,
        PlannedGoal,
        PlanResult,
        RunToMeasure,
        Separation,
    )
    from stiffcal.planning.rivals import PairInformation


def answer_of(
    campaign: Campaign, plan: PlanFile, model: PlanModel, chosen: ChosenRuns, purpose: Purpose, minutes_per_run: float
) -> PlanResult:
    """Return what the chosen runs would bring; separations, ways between the runs and remedies are not in it yet."""
    from stiffcal.planning.results import PlanResult

    choice, information = chosen.choice, chosen.information
    expected = _expected(campaign, model, chosen, choice.design.chosen)
    parameters = expected_parameters(model, information, choice, expected)
    taken = {run.id for run in campaign.manifest.runs}
    runs = runs_to_measure(chosen.candidates, choice, minutes_per_run, plan.minutes_per_step, taken)
    warnings = [*_warnings(campaign, model), *tracker_warnings(campaign, plan)]
    losses = losses_of_runs(choice, expected, information.names, runs)
    if losses:
        resting = "; ".join(f"{loss.parameter} on {loss.run}" for loss in losses)
        warnings.append(f"depends on one run: {resting}; measure it twice, or plan more runs")
    goals = _goals(purpose, chosen)
    counted = _counted(choice, expected, named_parameters(plan, information))
    return PlanResult(
        warnings=warnings,
        experiment=model.kind,
        criterion=_criterion(purpose),
        efficiency=choice.design.efficiency,
        candidates=len(chosen.candidates.joints),
        values_from=model.values_from,
        minutes=plan.warm_up_minutes + purpose.n_runs * minutes_per_run,
        warm_up_minutes=plan.warm_up_minutes,
        runs=runs,
        parameters=parameters,
        blocked_moves=[],
        rests_on_one_run=losses,
        gain=gain_of(expected, counted, plan.warm_up_minutes, minutes_per_run),
        not_identified=[parameter.name for parameter in parameters if not parameter.identified],
        prediction_half_width_m=_prediction(model, purpose, information, choice, expected),
        predicted_at=purpose.area.name,
        goals=goals,
        another_hour=_another_hour(campaign, model, chosen, expected, counted, minutes_per_run),
        observability=_observability(chosen, expected) if model.absolute else None,
        joint_names=campaign.chain.joint_names,
    )


def _criterion(purpose: Purpose) -> Literal["determinant", "worst", "prediction", "rivals", "mix"]:
    if len(purpose.goals) > 1:
        return "mix"
    if purpose.goals[0].name == LOOK_ALIKES:
        return "rivals"
    return "prediction" if purpose.goals[0].is_prediction else purpose.criterion.value


def _expected(campaign: Campaign, model: PlanModel, chosen: ChosenRuns, runs: Integers) -> ExpectedFit:
    """Return what runs bring with the tolerance of the geometry, on the parameters that are free."""
    from stiffcal.identification.fitting.geometry import geometry_columns
    from stiffcal.planning.expected import expected_fit

    free, known = chosen.choice.free, chosen.known
    own_known = None if known is None else known[np.ix_(free, free)]
    picked = chosen.candidates.subset(runs)
    if model.absolute:
        # the same places measure the geometry: it is in the model
        factors = model.information(picked).factors[:, :, free]
        return expected_fit(factors, np.zeros((*factors.shape[:2], 1)), np.zeros(1), own_known)
    of_runs = model.information(picked, further=partial(geometry_columns, model.robot))
    return expected_fit(of_runs.factors[:, :, free], of_runs.further, tolerances(campaign), own_known)


def _prediction(
    model: PlanModel, purpose: Purpose, information: RunInformation, choice: Choice, expected: ExpectedFit
) -> float | None:
    """Return the half width of the prediction, rms over the poses; what is not known there is left out."""
    from stiffcal.planning.choice import LARGEST_RELATIVE

    known = expected.course[-1] <= LARGEST_RELATIVE
    if not known.any():
        return None
    rows = model.predictions(purpose.area.joints, purpose.area.wrench, information.scale)[:, choice.free][:, known]
    mean_square = float(np.sum((rows @ expected.covariance[np.ix_(known, known)]) * rows) / (len(rows) / 3))
    return NORMAL_95 * float(np.sqrt(mean_square))


def _goals(purpose: Purpose, chosen: ChosenRuns) -> list[PlannedGoal] | None:
    from stiffcal.planning.results import PlannedGoal

    if not chosen.efficiencies:
        return None
    total = sum(goal.weight for goal in purpose.goals)
    return [
        PlannedGoal(goal=goal.name, weight=goal.weight / total, efficiency=efficiency)
        for goal, efficiency in zip(purpose.goals, chosen.efficiencies, strict=True)
    ]


def _another_hour(
    campaign: Campaign,
    model: PlanModel,
    chosen: ChosenRuns,
    expected: ExpectedFit,
    counted: Booleans,
    minutes_per_run: float,
) -> AnotherHour | None:
    """Return what another hour brings after all runs, spent on the runs that then serve best."""
    from stiffcal.planning.choice import LARGEST_RELATIVE, further_runs
    from stiffcal.planning.results import AnotherHour

    choice, free, known = chosen.choice, chosen.choice.free, chosen.known
    if not counted.any():
        return None
    count = max(1, round(HOUR / minutes_per_run))
    own_known = None if known is None else known[np.ix_(free, free)]
    further = further_runs(chosen.information.factors[:, :, free], choice.design.chosen, count, own_known, counted)
    later = _expected(campaign, model, chosen, np.concatenate([choice.design.chosen, further]))
    before, after = expected.course[-1, counted].max(), later.course[-1, counted].max()
    relative = NORMAL_95 * float(after) if after <= LARGEST_RELATIVE else None
    return AnotherHour(runs=count, worst_relative=relative, smaller=float(1.0 - after / before))


def _observability(chosen: ChosenRuns, expected: ExpectedFit) -> ObservabilityIndices | None:
    from stiffcal.identification.answers.observability import indices_of

    information, free = chosen.information, chosen.choice.free
    if not free.any():
        return None
    size = information.scale[free] / information.typical[free]
    return indices_of(expected.covariance * np.outer(size, size), len(chosen.choice.design.chosen))


def _counted(choice: Choice, expected: ExpectedFit, named: Booleans) -> Booleans:
    """Return which of the free parameters the plan identifies and is made for; all identified where these are none."""
    from stiffcal.planning.choice import LARGEST_RELATIVE

    identified = choice.identified[choice.free] & (expected.course[-1] <= LARGEST_RELATIVE)
    aimed = identified & named[choice.free]
    return np.asarray(aimed if aimed.any() else identified)


def tolerances(campaign: Campaign) -> Floats:
    """Return (6 J,) the standard deviations of the geometry, m and rad, as robot.toml states them or by default."""
    from stiffcal.identification.fitting.geometry_prior import GeometryPrior
    from stiffcal.identification.fitting.geometry_source import GeometrySource

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


def runs_to_measure(
    candidates: Candidates, choice: Choice, minutes: float, per_state: float, taken: Collection[str] = ()
) -> list[RunToMeasure]:
    """Return the chosen runs in an order of short moves, numbered after those whose names are taken."""
    from stiffcal.planning.choice import short_order
    from stiffcal.planning.results import RunToMeasure

    chosen = choice.design.chosen
    order = short_order(candidates.joints[chosen])
    last = max((int(match[1]) for name in taken if (match := NUMBERED.fullmatch(name))), default=0)
    width = max(2, len(str(last + len(chosen))))
    runs = [
        RunToMeasure(
            id=f"run{number:0{width}d}",
            joints=candidates.joints[chosen[rank]],
            wrench=candidates.wrench[chosen[rank]],
            minutes=minutes,
            minutes_per_state=per_state,
            approach=np.zeros((0, candidates.joints.shape[1])),
            rank=int(rank) + 1,
        )
        for number, rank in enumerate(order, start=last + 1)
    ]
    if candidates.turn is None:
        return runs
    largest = np.abs(candidates.turn[chosen[order]]).max(axis=1)
    return [
        replace(run, moved_joint=int(np.argmax(turn)) + 1, turn=float(turn.max()))
        for run, turn in zip(runs, largest, strict=True)
    ]


def gain_of(expected: ExpectedFit, counted: Booleans, warm_up: float, minutes: float) -> list[GainPoint]:
    """Return what the first 1, 2, … runs bring to the parameters that count, those of highest rank first."""
    from stiffcal.planning.choice import LARGEST_RELATIVE
    from stiffcal.planning.results import GainPoint

    worst = np.max(expected.course[:, counted], axis=1, initial=0.0)
    return [
        GainPoint(
            runs=number,
            minutes=warm_up + number * minutes,
            worst_relative=NORMAL_95 * float(size) if size <= LARGEST_RELATIVE else None,
        )
        for number, size in enumerate(worst, start=1)
    ]


def _warnings(campaign: Campaign, model: PlanModel) -> list[str]:
    """Return what a reader of the plan must know of its values."""
    warnings = []
    if model.assumed:
        warnings.append(f"{len(model.assumed)} parameters have typical values, so the expected uncertainties are rough")
    rods = [name for name, source in campaign.manifest.sources.items() if source.lengths is not None]
    if rods:
        warnings.append(
            f"rods are not counted: the expected uncertainties are without the lengths of {', '.join(rods)}"
        )
    return warnings


def separations_of(
    result: PlanResult, pairs: list[PairInformation], choice: Choice, named: list[NamedRival], readings: int
) -> PlanResult:
    """Return the answer with how far the chosen runs separate every ordered pair of rival models.

    Parameters
    ----------
    result : without it. pairs : of all candidates. choice : among them. named : the rivals.
    readings : how many numbers are measured, those so far and those of the plan.
    """
    from stiffcal.planning.results import Separation

    separations = []
    for pair in pairs:
        sizes = (pair.separation(np.tile(choice.design.chosen, times)) for times in range(1, MOST_TIMES + 1))
        size, needed = pair.separation(choice.design.chosen), separation_needed(readings)
        times = next((times for times, of_times in enumerate(sizes, start=1) if of_times >= needed), None)
        separations.append(
            Separation(
                truth=named[pair.truth].label,
                rival=named[pair.rival].label,
                chi_square=size,
                needed=needed,
                distinguished=size >= needed,
                times=times,
            )
        )
    alike = [_stay_alike(entry) for entry in separations if not entry.distinguished]
    return replace(result, separations=separations, warnings=[*result.warnings, *alike])


def separation_needed(readings: int) -> float:
    """Return the χ² between two models with which a diagnosis names the true one alone in 95 campaigns of 100.

    The difference of the two models' squares has the mean χ² and the standard deviation 2 √χ². It has to be
    `LOOK_ALIKE_ERRORS` such deviations, and `LOOK_ALIKE_SHARE` of the rms of all readings.

    Parameters
    ----------
    readings : how many numbers are measured.
    """
    from stiffcal.diagnosis.thresholds import LOOK_ALIKE_ERRORS, LOOK_ALIKE_SHARE

    by_errors = 2.0 * (LOOK_ALIKE_ERRORS + ONE_SIDED)
    by_share = ONE_SIDED + float(np.sqrt(ONE_SIDED**2 + 2.0 * LOOK_ALIKE_SHARE * readings))
    return max(by_errors, by_share) ** 2


def _stay_alike(entry: Separation) -> str:
    sizes = f"χ² = {significant(entry.chi_square, 2)} where {entry.needed:.0f} are needed"
    text = f"{entry.truth} and {entry.rival} cannot be separated: {sizes}"
    if entry.times is None:
        return f"{text}; repeats of these runs do not help: apply larger forces, or others"
    return f"{text}; each run {entry.times:.0f} times would do, or {entry.times:.0f} readings averaged in place of one"
