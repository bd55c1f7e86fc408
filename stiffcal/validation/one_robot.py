"""Which campaigns are of one robot, and which of its parameters can be compared between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.measured_frames import FRAME


def parameters_of_robot(
    campaigns: Sequence[Sequence[IdentifiedParameter]],
) -> list[list[IdentifiedParameter]]:
    """Return of each campaign the parameters that do not depend on where its own registration puts the tracker.

    Frames count from there, and so do lengths and angles next to a tracker that was found together with them: of its
    place along and about the first axis the registration decides, and the next links make up for it. They are then
    compared in no campaign.
    """
    if all(parameter.effect != FRAME for parameters in campaigns for parameter in parameters):
        return [list(parameters) for parameters in campaigns]
    return [[p for p in parameters if p.effect != FRAME and not _is_geometry(p)] for parameters in campaigns]


def _is_geometry(parameter: IdentifiedParameter) -> bool:
    from stiffcal.model.catalogue.catalogue import find_effects

    effect = find_effects().get(parameter.effect)
    return effect is not None and effect.spec(parameter.name.rsplit(".", 1)[1]).tolerance is not None


def require_one_robot(chains: list[Chain], before: Path, after: Path) -> None:
    """Raise InputError where the joints of two chains differ in number, or their axes lie otherwise to each other."""
    from stiffcal.mechanics.axis_distances import first_difference

    first, second = chains
    reason = ""
    if first.n_joints != second.n_joints:
        reason = f"its robot has {second.n_joints} joints, that of {before} has {first.n_joints}"
    elif (joint := first_difference(first, second)) is not None:
        reason = (
            f"its robot ({second.name}) is not that of {before} ({first.name}): distance or angle of axes {joint} and "
            f"{joint + 1} differs"
        )
    if reason:
        raise InputError.at(
            FaultCode.ROBOT_MISMATCH, str(after), "robot", reason, "select two campaigns of the same robot"
        )


def amplitude_of(parameter: IdentifiedParameter) -> float:
    """Return the quantity that the fit's covariance is of: the value, for stiffness-like parameters its inverse."""
    from stiffcal.model.catalogue.catalogue import find_effects
    from stiffcal.model.forms import form_of

    if parameter.value is None:
        return math.nan
    effect = find_effects().get(parameter.effect)
    symbol = parameter.name.rsplit(".", 1)[1]
    return parameter.value if effect is None else form_of(effect, [symbol]).spec(symbol).amplitude_of(parameter.value)
