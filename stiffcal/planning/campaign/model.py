"""The robot that a plan is made for: its values, noise, and what a fit knows already."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.checks.prismatic_checks import refuse_prismatic
from stiffcal.campaign.found.experiment_kinds import any_measures
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import HELD
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.catalogue.campaign_effects import free_names
from stiffcal.planning.measured import MeasuredSoFar
from stiffcal.reduction.logs.reading_bounds import LARGEST_FORCE_N

if TYPE_CHECKING:
    from stiffcal.identification.noise.reading_noise import Noise
    from stiffcal.identification.readings.observations import Observations
    from stiffcal.measurements.load_states import MeasurementSetup
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.planning.campaign.pairs import Candidates
    from stiffcal.planning.information import RunInformation, RunKind

Computed = TypeVar("Computed")
# Of a nonlinear parameter without a value: from a third to three times the typical one.
RANGE_FACTOR = 3.0


@dataclass(frozen=True)
class PlanModel:
    """The robot that the plan is made for."""

    robot: CompliantRobot
    """Every parameter with a value."""
    setup: MeasurementSetup
    """Where load and target are."""
    noise: Noise
    """Of one load state."""
    covariance: dict[str, dict[str, float]]
    """Of a fit to what was measured, by full names."""
    values_from: str
    """Where the values are from, in words."""
    assumed: frozenset[str]
    """Parameters with a typical value."""
    with_rotation: bool = False
    """Orientations are measured."""
    fixed: frozenset[str] = frozenset()
    """Full names of parameters that the fit does not free, or that others make up for in every pose."""
    kind: RunKind = "load"
    """What is measured."""
    readings: int = 0
    """How many numbers were measured so far."""

    @property
    def readings_per_state(self) -> int:
        """How many numbers a state of a planned run gives."""
        from stiffcal.planning.information import reads_along_lines

        return 1 if reads_along_lines(self.noise, self.setup) else 6 if self.with_rotation else 3

    @property
    def absolute(self) -> bool:
        """Whether places are measured, each pose once."""
        return self.kind == "absolute"

    def information(
        self,
        runs: Candidates,
        robot: CompliantRobot | None = None,
        further: Callable[[Observations], Floats] | None = None,
    ) -> RunInformation:
        """Return what runs bring on the robot's parameters, or on those of the same robot with other values.

        Raises
        ------
        InputError : the load is more than the springs hold.
        """
        from stiffcal.planning.information import information_of_runs

        return checked_balance(
            lambda: information_of_runs(
                robot or self.robot, runs.joints, runs.wrench, self.setup, self.noise, self.with_rotation, self.fixed,
                further, self.kind, runs.turn,
            )
        )  # fmt: skip

    def predictions(self, joints: Floats, wrench: Floats, scale: Floats) -> Floats:
        """Return (3 n, p) rows of predictions; as `prediction_rows`.

        Raises
        ------
        InputError : the load is more than the springs hold.
        """
        from stiffcal.planning.information import prediction_rows

        return checked_balance(
            lambda: prediction_rows(self.robot, joints, wrench, self.setup, scale, self.fixed, self.kind)
        )


def kind_of(campaign: Campaign, plan: PlanFile) -> RunKind:
    """Return what is planned: as plan.toml has it, else as the runs of campaign.toml are, else load runs.

    Raises
    ------
    InputError : the campaign's runs are of a kind that no plan is made for.
    """
    if plan.experiment is not None:
        return plan.experiment
    kinds = {run.experiment for run in campaign.manifest.runs}
    if not kinds:
        return "load"
    planned: dict[StateMeasure, RunKind] = {
        StateMeasure.DISPLACEMENT: "load",
        StateMeasure.PLACE: "absolute",
        StateMeasure.MOTOR_ANGLE: "clamped",
    }
    for measure, kind in planned.items():
        if any_measures(kinds, measure):
            return kind
    here = " or ".join(sorted(kinds))
    reason = f"all runs are {here} runs; plan supports load runs, absolute poses and clamped robots"
    # a joint on a bench of its own has no lever that a load at the flange could turn it by
    possible = "load" if campaign.chain.n_joints > 1 else "clamped"
    mend = f"write {toml_text.pair('experiment', possible)} in plan.toml to plan {possible} runs of this robot"
    raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, "campaign.toml", "runs", reason, mend)


def as_planned(campaign: Campaign, plan: PlanFile) -> Campaign:
    """Return the campaign with a run of the planned kind, where it has none: frames to be found depend on it."""
    from stiffcal.campaign.manifest.manifest import Run

    if kind_of(campaign, plan) != "absolute" or _has_places(campaign):
        return campaign
    runs = (*campaign.manifest.runs, Run(id="poses", experiment="absolute"))
    return replace(campaign, manifest=campaign.manifest.model_copy(update={"runs": runs}))


def _has_places(campaign: Campaign) -> bool:
    return any_measures((run.experiment for run in campaign.manifest.runs), StateMeasure.PLACE)


def refuse_lifts(campaign: Campaign) -> None:
    """Raise an error where the robot has prismatic joints.

    Raises
    ------
    InputError : it has.
    """
    refuse_prismatic(
        campaign.chain.prismatic_names,
        "plan chooses angles of revolute joints alone",
        "choose the poses yourself, and let stiffcal check judge them",
    )


def with_force(campaign: Campaign, plan: PlanFile, force: float | None) -> PlanFile:
    """Return plan.toml with a largest force in place of its own; None: as it is.

    Raises
    ------
    InputError : no robot holds the force, or absolute poses are planned, which have none.
    """
    if force is None:
        return plan
    if kind_of(campaign, plan) == "absolute":
        reason = "absolute poses are measured under the own weight of the robot and payloads"
        mend = 'leave --force out, or write experiment = "load" in plan.toml'
        raise InputError.at(FaultCode.OPTION_CONFLICT, "command line", "--force", reason, mend)
    if not force <= LARGEST_FORCE_N:
        reason = f"{force:g} N is more than any robot holds"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--force", reason, "give the largest force in N")
    return plan.model_copy(update={"load": plan.load.model_copy(update={"force_N": force})})


def fixed_names(campaign: Campaign) -> frozenset[str]:
    """Return the full names of parameters that model.toml fixes."""
    from stiffcal.model.assembled.assembly import fixed_parameters

    return fixed_parameters(campaign.model)


def checked_balance(compute: Callable[[], Computed]) -> Computed:
    """Return what a function computes.

    Raises
    ------
    InputError : the load is more than the springs hold.
    """
    from stiffcal.model.balance.equilibrium import NoBalanceError

    try:
        return compute()
    except NoBalanceError as error:
        mend = "correct the force, or the stiffness in model.toml"
        raise InputError.at(FaultCode.NO_BALANCE, PLAN_FILE, "load", str(error), mend) from None


def robot_to_plan(campaign: Campaign) -> CompliantRobot:
    """Return the campaign's robot, with the values of model.toml.

    Raises
    ------
    InputError : the model is empty, or a frame is not known.
    """
    from stiffcal.campaign.frames.frames import resolve_frames
    from stiffcal.model.catalogue.campaign_effects import placed_robot

    robot = placed_robot(campaign)
    if not robot.placed:
        mend = command_line("add", campaign.folder, "joint-compliance", "--all")
        raise InputError.at(FaultCode.MODEL_UNSUITABLE, "model.toml", "effects", "the model contains no effect", mend)
    resolve_frames(campaign.manifest, campaign.chain)
    return robot


def plan_model_of(
    campaign: Campaign, plan: PlanFile, robot: CompliantRobot, measured: MeasuredSoFar | None
) -> PlanModel:
    """Return the robot with values: fitted where there are logs, else of model.toml, else typical ones.

    Parameters
    ----------
    robot : the campaign's (`robot_to_plan`).
    measured : what was measured of it already; None: nothing.

    Raises
    ------
    InputError : the noise is not known, or a frame is not.
    """
    from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
    from stiffcal.compensation.prediction import at_load_point

    chain = campaign.chain
    frames = resolve_frames(campaign.manifest, chain)
    estimated: tuple[float | None, ...] = (None,) * 6
    covariance: dict[str, dict[str, float]] = {}
    if measured is not None:
        robot, setup, covariance = measured.robot, measured.setup, measured.covariance
        estimated, source = measured.noise, measured.source
    else:
        setup = measurement_setup(campaign.manifest, chain, frames)
        source = "model.toml"
    robot, assumed = _with_typical_values(campaign, plan, robot)
    if assumed:
        n_parameters = sum(len(placed_effect.effect.parameters) for placed_effect in robot.placed)
        source = "typical values" if len(assumed) == n_parameters else f"{source}, and typical values"
    if kind_of(campaign, plan) == "clamped":
        setup = replace(setup, targets=(setup.wrench_point,), target_names=(HELD,))
    if not setup.targets:
        mend = "add a source with a pose or a deflection"
        raise InputError.at(FaultCode.SIGNAL_MISSING, "campaign.toml", "sources", "no displacement is measured", mend)
    if plan.load.point is not None:
        if plan.load.point not in frames:
            mend = f"frames: {', '.join(frames)}"
            reason = f"unknown frame {plan.load.point}"
            raise InputError.at(FaultCode.FRAME_UNKNOWN, PLAN_FILE, "load.point", reason, mend)
        setup = replace(setup, wrench_point=frames[plan.load.point])
    noise = _noise(campaign, plan, setup, estimated)
    setup = replace(at_load_point(setup), estimated=())
    turned, kind = with_rotation(campaign), kind_of(campaign, plan)
    model = PlanModel(
        robot, setup, noise, covariance, source, assumed, turned, fixed_names(campaign), kind,
        0 if measured is None else measured.readings,
    )  # fmt: skip
    return _of_places(model) if model.absolute else model


def _of_places(model: PlanModel) -> PlanModel:
    """Return the model for absolute places: what others make up for in every pose is not free."""
    from stiffcal.identification.fitting.gauge import redundant_geometry
    from stiffcal.planning.information import observations_of_runs

    joints = np.zeros((1, len(model.robot.chain.joint_names)))
    data = observations_of_runs(model.robot, joints, np.zeros((1, 1, 6)), model.setup, model.with_rotation, "absolute")
    redundant = redundant_geometry(model.robot, data, model.fixed)
    return replace(model, fixed=model.fixed | redundant)


def _with_typical_values(
    campaign: Campaign, plan: PlanFile, robot: CompliantRobot
) -> tuple[CompliantRobot, frozenset[str]]:
    """Return the robot with a value for every parameter, and the names of those that are typical."""
    from stiffcal.mechanics.robot_classes import typical_compliance
    from stiffcal.planning.information import counts_from_nominal

    without_value = set(free_names(robot)[0])
    values: dict[str, float] = {}
    nominal: set[str] = set()
    for placed_effect in robot.placed:
        for spec in placed_effect.effect.parameters:
            name = placed_effect.parameter_name(spec.symbol)
            if name not in without_value:
                continue
            values[name] = spec.typical
            if counts_from_nominal(placed_effect) and not spec.discrete:
                values[name] = spec.neutral
                nominal.add(name)
            elif plan.robot_class is not None and placed_effect.effect.name == "joint-compliance":
                values[name] = typical_compliance(plan.robot_class, placed_effect.place.joints[0])
    return robot.with_values(values), frozenset(values.keys() - nominal)


def _noise(campaign: Campaign, plan: PlanFile, setup: MeasurementSetup, found: tuple[float | None, ...]) -> Noise:
    """Return the noise of one load state: of plan.toml, else as the fit found it, else as campaign.toml states it."""
    from stiffcal.identification.noise.reading_noise import Noise

    def first_known(*sizes: float | None) -> float | None:
        return next((size for size in sizes if size is not None), None)

    sigma, stated = setup.sigma, plan.noise
    translation = first_known(stated.translation_m, found[0], sigma.translation)
    rotation = first_known(stated.rotation_rad, found[1], sigma.rotation)
    force = first_known(stated.force_N, found[2], sigma.force)
    moment = first_known(stated.moment_Nm, found[3], sigma.moment)
    clamped = kind_of(campaign, plan) == "clamped"
    motor_angle = first_known(stated.motor_angle_rad, found[4])
    if clamped and motor_angle is None:
        reason = "neither plan.toml nor a fit has the noise of the driven motors' angles"
        mend = "add [noise] with motor_angle_rad = 5e-6, the standard uncertainty of one load state at the joint's side"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "noise.motor_angle_rad", reason, mend)
    gauge = first_known(stated.translation_m, found[5], sigma.gauge) if along_lines(campaign, setup) else None
    if gauge:
        translation = 0.0
    if translation is None and not clamped:
        reason = "neither plan.toml nor campaign.toml nor a fit has the noise of the measured position"
        too = " and rotation_rad = 2e-5" if rotation is None and with_rotation(campaign) else ""
        mend = f"add [noise] with translation_m = 2e-5{too}, the standard uncertainty of one load state"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "noise.translation_m", reason, mend)
    if rotation is None and with_rotation(campaign) and not clamped:
        reason = "orientation is measured, and neither plan.toml nor campaign.toml nor a fit has its noise"
        mend = "add [noise] with rotation_rad = 2e-5, the standard uncertainty of one load state"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "noise.rotation_rad", reason, mend)
    sizes = (translation or 0.0, rotation or 0.0, force or 0.0, moment or 0.0)
    return Noise(*sizes, "manifest", np.inf, motor_angle=motor_angle or 0.0, gauge=gauge or 0.0)


def along_lines(campaign: Campaign, setup: MeasurementSetup) -> bool:
    """Return whether displacement is measured by devices along their lines alone."""
    in_space = (source.body_poses() or source.deflection for source in campaign.manifest.sources.values())
    return bool(setup.gauges) and not any(in_space)


def with_rotation(campaign: Campaign) -> bool:
    """Return whether orientations are measured."""
    for source in campaign.manifest.sources.values():
        if any(pose.orientation is not None for pose in source.body_poses().values()):
            return True
        if source.deflection is not None and source.deflection.rotation is not None:
            return True
    return False
