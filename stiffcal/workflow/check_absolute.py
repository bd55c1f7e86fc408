"""What absolute places measured so far say of each joint, and what more poses are needed for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiffcal.errors import InputError
from stiffcal.workflow.check_results import CheckedJoint

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.identification.fit import Fit
    from stiffcal.identification.observability import ObservabilityIndices
    from stiffcal.measurements.load_states import LoadStates

MOST_NAMED = 6
"""Parameters that a sentence lists."""


@dataclass(frozen=True)
class CheckedPlaces:
    """What absolute places determine."""

    joints: list[CheckedJoint]
    """How well weight and payload show each joint's stiffness."""
    missing: list[str]
    """What the poses leave open, in words."""
    observability: ObservabilityIndices | None = None
    """Indices of the poses; None where nothing could be fitted."""


def joints_from_places(campaign: Campaign, states: LoadStates) -> CheckedPlaces:
    """Return what the places measured so far determine, and what they leave open."""
    from stiffcal.identification.identify import identify_parameters
    from stiffcal.identification.observability import observability_of
    from stiffcal.model.campaign_effects import placed_robot
    from stiffcal.model.equilibrium import NoBalanceError, solve_balance

    robot = placed_robot(campaign)
    used = states.select(states.used)
    n_numbers = sum(1 for placed in robot.placed for spec in placed.effect.parameters if not spec.discrete)
    if 3 * len(used) < n_numbers:
        text = f"{len(used)} poses are too few for {n_numbers} numbers: measure at least {n_numbers // 2}"
        return CheckedPlaces([], [text])
    try:
        fit = identify_parameters(states, robot)
        angles = campaign.chain.model_angles(used.joints)
        torque = abs(solve_balance(fit.robot, angles, used.wrench, used.setup).joint_torque).max(axis=0)
    except (InputError, NoBalanceError) as error:
        return CheckedPlaces([], [str(error)])
    joints = [
        _joint(name, float(torque[number]), fit, number + 1) for number, name in enumerate(campaign.chain.joint_names)
    ]
    return CheckedPlaces(joints, _open_geometry(fit), observability_of(fit))


def _joint(name: str, torque: float, fit: Fit, number: int) -> CheckedJoint:
    """Return what is known of a joint's compliance about its axis."""
    own = [
        parameter
        for parameter in fit.parameters
        if parameter.spec.compliance and parameter.place.joints == (number,) and parameter.spec.along == 5
    ]
    if not own:
        relative, text = None, "the model holds no compliance about its axis"
    elif own[0].value is None:
        what = "weight does not turn it" if fit.data.absolute.all() else "neither weight nor load turns it"
        relative, text = None, f"{what} in these poses: its stiffness cannot be identified from them"
    elif not own[0].value or own[0].std is None:
        relative, text = None, "no compliance shows in these poses"
    else:
        relative = own[0].std / own[0].value
        text = f"known to about {100.0 * relative:.2g} %"
    return CheckedJoint(joint=name, largest_torque_Nm=torque, expected_relative_std=relative, says=text)


def _open_geometry(fit: Fit) -> list[str]:
    """Return one line where poses leave geometry or frames open that other poses would determine."""
    from stiffcal.identification.gauge import redundant_geometry

    redundant = redundant_geometry(fit.robot, fit.data, frozenset())
    unknown = [
        parameter.name
        for parameter in fit.parameters
        if parameter.value is None and not parameter.spec.compliance and parameter.name not in redundant
    ]
    if not unknown:
        return []
    names = ", ".join(unknown[:MOST_NAMED]) + (
        f" and {len(unknown) - MOST_NAMED} more" if len(unknown) > MOST_NAMED else ""
    )
    return [f"these poses do not determine {names}: measure poses in which every joint turns farther"]
