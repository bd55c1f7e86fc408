"""What is known of a robot before it is measured, and what its model may turn out to be."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.planning.information import RunInformation
from stiffcal.planning.campaign.model import RANGE_FACTOR, PlanModel


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
            raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, place, "not a possible range", mend)
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
