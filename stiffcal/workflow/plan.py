"""Plan which poses and loads to measure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile, load_plan
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.uncertainty import NORMAL_95
from stiffcal.workflow.plan_means import cell_of, load_steps
from stiffcal.workflow.plan_program import check_program, write_program
from stiffcal.workflow.steps import RunContext, free_names, with_trial_model

if TYPE_CHECKING:
    from stiffcal.identification.fit_results import NoisePerAxis
    from stiffcal.identification.noise import Noise
    from stiffcal.measurements.load_states import Attachment, MeasurementSetup
    from stiffcal.model.composite import CompliantRobot
    from stiffcal.planning.candidates import Cell
    from stiffcal.planning.choice import Choice
    from stiffcal.planning.expected import ExpectedFit
    from stiffcal.planning.information import RunInformation
    from stiffcal.planning.results import ExpectedParameter, GainPoint, LossOfRun, PlanResult, RunToMeasure

Floated = TypeVar("Floated")
DEFAULT_RUNS = 12


@dataclass(frozen=True)
class PlanRequest:
    """What a plan is for."""

    purpose: str = "stiffness"
    """"stiffness", or a CSV of poses and loads where deflection is to be predicted."""
    criterion: Literal["determinant", "worst"] = "worst"
    """What counts for "stiffness"."""
    runs: int | None = None
    """Number of runs; None: as plan.toml has it."""
    force: float | None = None
    """Largest force, N; None: as plan.toml has it."""
    sheet: Path | None = None
    """CSV file to write the run sheet to; None: nothing is written."""
    program: Path | None = None
    """Robot program to write, its ending states the language (`robot_programs`); None: none is written."""
    campaign: Path | None = None
    """Campaign folder to make ready for the logs; None: none is made."""


@dataclass(frozen=True)
class _Model:
    """The robot that the plan is made for."""

    robot: CompliantRobot
    setup: MeasurementSetup
    noise: Noise
    covariance: dict[str, dict[str, float]]
    values_from: str
    assumed: frozenset[str]


@dataclass(frozen=True)
class _Candidates:
    """N pairs of a possible pose and a direction of load."""

    joints: Floats
    """(N, L) rad."""
    wrench: Floats
    """(N, K, 6) the load steps."""


def plan_campaign(folder: Path, context: RunContext | None = None, request: PlanRequest | None = None) -> PlanResult:
    """Plan which poses and loads to measure with the means of plan.toml.

    Parameters
    ----------
    folder : a campaign folder; its logs need not exist. What was measured already counts.
    context : store, progress and so on.
    request : what the plan is for.

    Returns
    -------
    PlanResult
        The runs in the order of measuring, and the expected uncertainty of every parameter.

    Raises
    ------
    InputError : the input is wrong, no pose is possible, or no possible load turns any parameter's joint.
    """
    from stiffcal.planning.choice import choose_runs
    from stiffcal.planning.design import Criterion
    from stiffcal.planning.expected import expected_fit
    from stiffcal.planning.information import information_of_runs, prediction_rows
    from stiffcal.planning.results import PlanResult

    context, request = context or RunContext(), request or PlanRequest()
    folder = Path(folder)
    campaign = with_trial_model(load_campaign(folder, check_files=False), context)
    plan = load_plan(folder)
    if request.force is not None:
        plan = plan.model_copy(update={"load": plan.load.model_copy(update={"force_N": request.force})})
    if request.program is not None:
        check_program(request.program, campaign)
    model = _model(campaign, plan, context)
    context.progress("possible poses", 0.1)
    candidates = _candidates(campaign, plan, model)
    context.progress("information of each run", 0.3)
    fixed = _fixed(campaign)
    information = _checked_balance(
        lambda: information_of_runs(
            model.robot, candidates.joints, candidates.wrench, model.setup, model.noise, _with_rotation(campaign), fixed
        )
    )
    wanted, criterion = None, Criterion(request.criterion)
    if request.purpose != "stiffness":
        from stiffcal.compensation.load_table import read_load_table

        criterion = Criterion.PREDICTION
        table = read_load_table(Path(request.purpose), campaign.chain.joint_names, joints_needed=True)
        wanted = _checked_balance(
            lambda: prediction_rows(model.robot, table.joints, table.wrench, model.setup, information.scale, fixed)
        )
    minutes_per_run = plan.minutes_per_run + plan.minutes_per_step * (candidates.wrench.shape[1] + 2)
    n_runs = _number_of_runs(plan, request, minutes_per_run)
    context.progress("choosing runs", 0.6)
    known = _known_information(model, information)
    choice = choose_runs(information.factors, n_runs, criterion, known, wanted, plan.repeats, information.nonlinear)
    if choice is None or not choice.identified.any():
        reason = "no possible load turns any parameter of the model enough to identify it"
        mend = "allow other directions, a larger force, or a load point with a lever arm"
        raise InputError.at(FaultCode.DATA_MISSING, PLAN_FILE, "load", reason, mend)
    context.progress("expected uncertainties", 0.8)
    chosen = choice.design.chosen
    of_chosen = information_of_runs(
        model.robot, candidates.joints[chosen], candidates.wrench[chosen], model.setup, model.noise,
        _with_rotation(campaign), fixed, with_geometry=True,
    )  # fmt: skip
    free = choice.free
    expected = expected_fit(
        of_chosen.factors[:, :, free], _geometry(of_chosen), _tolerances(campaign),
        None if known is None else known[np.ix_(free, free)],
    )  # fmt: skip
    parameters = _expected(model, information, choice, expected)
    not_identified = [parameter.name for parameter in parameters if not parameter.identified]
    warnings = _warnings(model)
    runs = _runs(candidates, choice, minutes_per_run)
    context.progress("moves between the runs", 0.9)
    cell = cell_of(campaign, plan)
    runs, blocked = _with_ways(campaign, cell, model, np.unique(candidates.joints, axis=0), runs)
    if blocked:
        pairs = ", ".join(f"{before} to {after}" for before, after in blocked)
        warnings.append(f"no joint move stays out of the boxes and above lowest_m: {pairs}; drive by hand")
    losses = _losses_of_runs(choice, expected, information.names, runs)
    if losses:
        named = "; ".join(f"{loss.parameter} on {loss.run}" for loss in losses)
        warnings.append(f"rests on one run: {named}; measure it twice, or plan more runs")
    half_width = None
    if wanted is not None:
        mean_square = float(
            np.sum((wanted[:, choice.free] @ expected.covariance) * wanted[:, choice.free]) / (len(wanted) / 3)
        )
        half_width = NORMAL_95 * float(np.sqrt(mean_square))
    result = PlanResult(
        warnings=warnings,
        criterion=criterion.value,
        efficiency=choice.design.efficiency,
        candidates=len(candidates.joints),
        values_from=model.values_from,
        minutes=plan.warm_up_minutes + n_runs * minutes_per_run,
        runs=runs,
        parameters=parameters,
        blocked_moves=blocked,
        rests_on_one_run=losses,
        gain=_gain(choice, expected, plan.warm_up_minutes, minutes_per_run),
        not_identified=not_identified,
        prediction_half_width_m=half_width,
        joint_names=campaign.chain.joint_names,
    )
    if request.program is not None:
        write_program(request.program, campaign, result, cell)
        result = replace(result, program=str(request.program))
    if request.campaign is not None:
        from stiffcal.workflow.plan_folder import write_planned_campaign

        files = write_planned_campaign(request.campaign, campaign, result)
        result = replace(result, folder=str(request.campaign), files=files)
    if request.sheet is not None:
        from stiffcal.workflow.plan_sheet import write_run_sheet

        write_run_sheet(request.sheet, result)
        result = replace(result, file=str(request.sheet))
    return result


def _fixed(campaign: Campaign) -> frozenset[str]:
    from stiffcal.model.assembly import fixed_parameters

    return fixed_parameters(campaign.model)


def _checked_balance(compute: Callable[[], Floated]) -> Floated:
    from stiffcal.model.equilibrium import NoBalanceError

    try:
        return compute()
    except NoBalanceError as error:
        mend = "correct the force, or the stiffness in model.toml"
        raise InputError.at(FaultCode.NO_BALANCE, PLAN_FILE, "load", str(error), mend) from None


def _model(campaign: Campaign, plan: PlanFile, context: RunContext) -> _Model:
    """Return the robot with values: fitted where there are logs, else of model.toml, else typical ones."""
    from stiffcal.campaign.frames import measurement_setup, resolve_frames
    from stiffcal.compensation.prediction import at_load_point
    from stiffcal.ingest.sources import manifest_data_files
    from stiffcal.model.campaign_effects import placed_robot

    robot = placed_robot(campaign)
    if not robot.placed:
        mend = f"stiffcal add {campaign.folder} joint-compliance --all"
        raise InputError.at(FaultCode.MODEL_UNSUITABLE, "model.toml", "effects", "the model holds no effect", mend)
    chain = campaign.chain
    frames = resolve_frames(campaign.manifest, chain)
    files = manifest_data_files(campaign)
    estimated: NoisePerAxis | None = None
    assumed: frozenset[str] = frozenset()
    covariance: dict[str, dict[str, float]] = {}
    if files and all((campaign.folder / file).exists() for file in files):
        from stiffcal.workflow.fitted_robot import fitted_robot
        from stiffcal.workflow.identify import up_to_date_fit
        from stiffcal.workflow.steps import up_to_date_states

        fitted = fitted_robot(campaign, context)
        estimated = up_to_date_fit(up_to_date_states(campaign.folder, context), context).noise_per_axis
        robot, setup, covariance, source = fitted.robot, fitted.setup, fitted.covariance, fitted.source
    else:
        setup = measurement_setup(campaign.manifest, chain, frames)
        source = "model.toml"
    without_value, _ = free_names(campaign, robot)
    if without_value:
        typical = {
            placed_effect.parameter_name(spec.symbol): spec.typical
            for placed_effect in robot.placed
            for spec in placed_effect.effect.parameters
        }
        robot = robot.with_values({name: typical[name] for name in without_value})
        assumed = frozenset(without_value)
        source = "typical values" if len(assumed) == len(typical) else f"{source}, and typical values"
    if not setup.targets:
        mend = "add a source with a pose or a deflection"
        raise InputError.at(FaultCode.SIGNAL_MISSING, "campaign.toml", "sources", "no displacement is measured", mend)
    if plan.load.point is not None:
        if plan.load.point not in frames:
            mend = f"frames: {', '.join(frames)}"
            reason = f"no frame is called {plan.load.point}"
            raise InputError.at(FaultCode.FRAME_UNKNOWN, PLAN_FILE, "load.point", reason, mend)
        setup = replace(setup, wrench_point=frames[plan.load.point])
    noise = _noise(campaign, plan, setup, estimated)
    setup = replace(at_load_point(setup), estimated=())
    return _Model(robot, setup, noise, covariance, source, assumed)


def _noise(campaign: Campaign, plan: PlanFile, setup: MeasurementSetup, estimated: NoisePerAxis | None) -> Noise:
    """Return the noise of one load state: of plan.toml, else as the fit found it, else as campaign.toml states it."""
    from stiffcal.identification.noise import Noise

    def first_known(*sizes: float | None) -> float | None:
        return next((size for size in sizes if size is not None), None)

    sigma, stated = setup.sigma, plan.noise
    found = (
        (None,) * 4
        if estimated is None
        else (estimated.translation, estimated.rotation, estimated.force, estimated.moment)
    )
    translation = first_known(stated.translation_m, found[0], sigma.translation)
    rotation = first_known(stated.rotation_rad, found[1], sigma.rotation)
    force = first_known(stated.force_N, found[2], sigma.force)
    moment = first_known(stated.moment_Nm, found[3], sigma.moment)
    if translation is None:
        reason = "neither plan.toml nor campaign.toml nor a fit has the noise of the measured position"
        mend = "add [noise] with translation_m = 2e-5, the standard uncertainty of one load state"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "noise.translation_m", reason, mend)
    if rotation is None and _with_rotation(campaign):
        reason = "orientation is measured, and neither plan.toml nor campaign.toml nor a fit has its noise"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "noise.rotation_rad", reason, "add it under [noise]")
    return Noise(translation, rotation or 0.0, force or 0.0, moment or 0.0, "manifest", np.inf)


def _with_rotation(campaign: Campaign) -> bool:
    """Return whether orientations are measured."""
    for source in campaign.manifest.sources.values():
        if any(pose.orientation is not None for pose in source.body_poses().values()):
            return True
        if source.deflection is not None and source.deflection.rotation is not None:
            return True
    return False


def _candidates(campaign: Campaign, plan: PlanFile, model: _Model) -> _Candidates:
    from stiffcal.planning.candidates import possible_poses

    cell = cell_of(campaign, plan)
    tips = _tips(campaign, model)
    joints, rejected = possible_poses(campaign.chain, cell, model.setup.targets[0], tips, plan.candidates, plan.seed)
    if not len(joints):
        counts = {
            "keep_out": (rejected.collision, "a link enters a keep-out box or goes below lowest_m"),
            "tracker.cone_deg": (rejected.out_of_view, "the measured frame is outside of the tracker's field of view"),
            "tracker.acceptance_deg": (rejected.reflector, "the reflector is turned away from the tracker"),
        }
        place, (count, why) = max(counts.items(), key=lambda entry: entry[1][0])
        reason = f"none of {rejected.drawn} poses within the joint limits is possible: in {count} of them {why}"
        raise InputError.at(FaultCode.POSE_UNREACHABLE, PLAN_FILE, place, reason, "correct it, or widen limits_deg")
    loads = load_steps(campaign, plan)
    n, directions = len(joints), len(loads)
    return _Candidates(np.repeat(joints, directions, axis=0), np.tile(loads, (n, 1, 1)))


def _tips(campaign: Campaign, model: _Model) -> tuple[Attachment, ...]:
    """Return the frames on the flange that the last capsules reach to."""
    frames = (model.setup.wrench_point, *model.setup.targets)
    return tuple(frame for frame in frames if frame.body == campaign.chain.n_joints + 1)


def _with_ways(
    campaign: Campaign, cell: Cell, model: _Model, poses: Floats, runs: list[RunToMeasure]
) -> tuple[list[RunToMeasure], list[list[str]]]:
    """Return the runs with the poses to drive through before each, and the pairs between which no way is free."""
    from stiffcal.planning.moves import ways_between

    joints = np.stack([run.joints for run in runs])
    ways = ways_between(campaign.chain, cell, _tips(campaign, model), joints, poses)
    blocked = [[runs[k].id, runs[k + 1].id] for k, way in enumerate(ways) if way is None]
    reached = [replace(run, approach=way) if way is not None else run for run, way in zip(runs[1:], ways, strict=True)]
    return [runs[0], *reached], blocked


def _number_of_runs(plan: PlanFile, request: PlanRequest, minutes_per_run: float) -> int:
    if request.runs is not None:
        return request.runs
    if plan.minutes is not None:
        allowed = int((plan.minutes - plan.warm_up_minutes) / minutes_per_run)
        if allowed < 1:
            reason = f"{plan.minutes:g} min do not suffice for the warm-up and one run of {minutes_per_run:g} min"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, "minutes", reason, "allow more time")
        return min(allowed, plan.runs) if plan.runs is not None else allowed
    return plan.runs if plan.runs is not None else DEFAULT_RUNS


def _known_information(model: _Model, information: RunInformation) -> Floats | None:
    """Return (p, p) what a fit knows already, relative to the values; None where nothing was measured."""
    names = [name for name in information.names if name in model.covariance]
    if not names:
        return None
    places = [information.names.index(name) for name in names]
    matrix = np.array([[model.covariance[a][b] for b in names] for a in names])
    scale = information.scale[places]
    known = np.zeros((len(information.names),) * 2)
    known[np.ix_(places, places)] = np.linalg.inv(matrix / scale[:, None] / scale)
    return 0.5 * (known + known.T)


def _geometry(information: RunInformation) -> Floats:
    assert information.geometry is not None
    return information.geometry


def _tolerances(campaign: Campaign) -> Floats:
    """Return (6 J,) the standard deviations of the geometry, m and rad, as robot.toml states them or by default."""
    from stiffcal.identification.geometry_prior import GeometryPrior, GeometrySource

    tolerance = campaign.chain.tolerance
    prior = GeometryPrior(tolerance.length, tolerance.angle, GeometrySource.DEFAULT)
    return prior.sizes(campaign.chain.n_joints)


def _losses_of_runs(
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


def _expected(model: _Model, information: RunInformation, choice: Choice, fit: ExpectedFit) -> list[ExpectedParameter]:
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


def _runs(candidates: _Candidates, choice: Choice, minutes: float) -> list[RunToMeasure]:
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


def _gain(choice: Choice, expected: ExpectedFit, warm_up: float, minutes: float) -> list[GainPoint]:
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


def _warnings(model: _Model) -> list[str]:
    warnings = []
    if model.assumed:
        warnings.append(f"{len(model.assumed)} parameters have typical values: expected uncertainties are as rough")
    return warnings
