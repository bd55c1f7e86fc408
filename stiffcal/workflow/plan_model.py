"""The robot that a plan is made for: its values, noise, and what a fit knows already."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.workflow.steps import RunContext, free_names

if TYPE_CHECKING:
    from stiffcal.identification.fit_results import NoisePerAxis
    from stiffcal.identification.noise import Noise
    from stiffcal.measurements.load_states import MeasurementSetup
    from stiffcal.model.composite import CompliantRobot
    from stiffcal.planning.information import RunInformation

Computed = TypeVar("Computed")
# Of a nonlinear parameter without a value: from a third to three times the typical one.
RANGE_FACTOR = 3.0


@dataclass(frozen=True)
class PlanModel:
    """The robot that the plan is made for."""

    robot: CompliantRobot
    setup: MeasurementSetup
    noise: Noise
    covariance: dict[str, dict[str, float]]
    values_from: str
    assumed: frozenset[str]


def fixed_names(campaign: Campaign) -> frozenset[str]:
    """Return the full names of parameters that model.toml fixes."""
    from stiffcal.model.assembly import fixed_parameters

    return fixed_parameters(campaign.model)


def checked_balance(compute: Callable[[], Computed]) -> Computed:
    """Return what a function computes.

    Raises
    ------
    InputError : the load is more than the springs hold.
    """
    from stiffcal.model.equilibrium import NoBalanceError

    try:
        return compute()
    except NoBalanceError as error:
        mend = "correct the force, or the stiffness in model.toml"
        raise InputError.at(FaultCode.NO_BALANCE, PLAN_FILE, "load", str(error), mend) from None


def planned_model(campaign: Campaign, plan: PlanFile, context: RunContext) -> PlanModel:
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
    return PlanModel(robot, setup, noise, covariance, source, assumed)


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
    if rotation is None and with_rotation(campaign):
        reason = "orientation is measured, and neither plan.toml nor campaign.toml nor a fit has its noise"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "noise.rotation_rad", reason, "add it under [noise]")
    return Noise(translation, rotation or 0.0, force or 0.0, moment or 0.0, "manifest", np.inf)


def with_rotation(campaign: Campaign) -> bool:
    """Return whether orientations are measured."""
    for source in campaign.manifest.sources.values():
        if any(pose.orientation is not None for pose in source.body_poses().values()):
            return True
        if source.deflection is not None and source.deflection.rotation is not None:
            return True
    return False


def known_information(model: PlanModel, information: RunInformation) -> Floats | None:
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


def prior_scenarios(plan: PlanFile, model: PlanModel) -> list[CompliantRobot]:
    """Return the robot with its values, and with the unknown nonlinear parameters at both ends of their ranges.

    Raises
    ------
    InputError : a range is of no nonlinear parameter of the model, empty, or beyond what is possible.
    """
    from stiffcal.model.effect import ParameterRole

    specs = {
        placed.parameter_name(spec.symbol): spec
        for placed in model.robot.placed
        for spec in placed.specs(ParameterRole.NONLINEAR)
        if not spec.discrete
    }
    ends: dict[str, tuple[float, float]] = {}
    for name in sorted(specs.keys() & model.assumed):
        typical = specs[name].typical
        factor = RANGE_FACTOR if typical > 0.0 else 1.0 / RANGE_FACTOR
        ends[name] = typical / factor, typical * factor
    for name, (low, high) in plan.prior_range.items():
        place = f"prior_range.{name}"
        if name not in specs:
            mend = f"nonlinear parameters: {', '.join(sorted(specs)) or 'none'}"
            reason = "the model has no nonlinear parameter of this name"
            raise InputError.at(FaultCode.PARAMETER_UNKNOWN, PLAN_FILE, place, reason, mend)
        if not specs[name].lower <= low < high <= specs[name].upper:
            mend = f"write the lower end first, from {specs[name].lower:g} to {specs[name].upper:g} {specs[name].unit}"
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, place, "no possible range", mend)
        ends[name] = low, high
    if not ends:
        return [model.robot]
    clipped = {
        name: tuple(min(max(end, specs[name].lower), specs[name].upper) for end in both) for name, both in ends.items()
    }
    extremes = [model.robot.with_values({name: both[side] for name, both in clipped.items()}) for side in (0, 1)]
    return [model.robot, *extremes]


def has_nonlinear_laws(robot: CompliantRobot) -> bool:
    """Return whether an effect has a crossing, a knee or a memory: what loads of one sense do not show."""
    from stiffcal.model.effect import ParameterRole

    return robot.has_memory or any(placed.specs(ParameterRole.NONLINEAR) for placed in robot.placed)
