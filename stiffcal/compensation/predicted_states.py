"""What is predicted, state by state, and as a table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.compensation.load_table import LoadTable
from stiffcal.compensation.loaded_columns import loaded_columns
from stiffcal.quantity import LENGTH, of_joint

if TYPE_CHECKING:
    from stiffcal.compensation.link_parts import LinkPart
    from stiffcal.compensation.predict_result import PredictedLink, PredictedState, PredictResult
    from stiffcal.compensation.prediction import Prediction


def predicted_states(
    loads: LoadTable, prediction: Prediction, link_parts_of_path: tuple[LinkPart, ...]
) -> list[PredictedState]:
    """Return every state with its links' parts."""
    from stiffcal.compensation.predict_result import PredictedState

    return [
        PredictedState(
            joints=loads.joints[place],
            wrench=loads.wrench[place],
            deflection=prediction.deflection[place],
            covariance=prediction.covariance[place],
            cartesian_compliance=prediction.cartesian_compliance[place],
            cartesian_stiffness=prediction.cartesian_stiffness[place],
            linear_compliance=prediction.linear_compliance[place],
            linear_stiffness=prediction.linear_stiffness[place],
            links=[_predicted_link(link_part, place) for link_part in link_parts_of_path],
        )
        for place in range(len(loads.joints))
    ]


def _predicted_link(link_part: LinkPart, place: int) -> PredictedLink:
    from stiffcal.compensation.predict_result import PredictedLink

    def there(values: Floats | None) -> Floats | None:
        return None if values is None else np.asarray(values[place])

    return PredictedLink(
        link=link_part.link,
        carried=link_part.carried[place],
        end=there(link_part.end),
        at_target=there(link_part.at_target),
        end_by_compliance=there(link_part.end_by_compliance),
        at_target_by_compliance=there(link_part.at_target_by_compliance),
    )


def unknown_twists(fitted: FittedRobot, parts: tuple[LinkPart, ...]) -> Iterator[str]:
    """Yield which links' rods do not identify their torsion."""
    for link_part in parts:
        if link_part.link in fitted.link_compliances and not np.isfinite(fitted.link_compliances[link_part.link][3, 3]):
            has = "without torsion" if link_part.end is None else "with that of the fit"
            yield f"the rods on {link_part.link} do not identify its torsion: its part by the 6×6 of the rods is {has}"


def table_of_states(result: PredictResult) -> dict[str, Floats]:
    """Return the prediction as columns: degrees, N, N·m, mm, mrad, each with its unit."""
    states = result.states
    joints, wrench = np.array([state.joints for state in states]), np.array([state.wrench for state in states])
    factors = np.array([of_joint(unit == LENGTH.usual.name).usual.factor for unit in result.joint_units])
    deflection = np.array([state.deflection for state in states])
    std = np.sqrt([np.diagonal(state.covariance) for state in states])
    columns = loaded_columns(
        result.joint_names, result.joint_units, factors * joints, wrench, deflection, std, "standard uncertainty"
    )
    for number, link in enumerate(states[0].links):
        link_parts = [state.links[number] for state in states]
        for by_method, by in (
            ([link_part.at_target for link_part in link_parts], ""),
            ([link_part.at_target_by_compliance for link_part in link_parts], " by its 6x6"),
        ):
            given_ways = [direction for direction in by_method if direction is not None]
            if given_ways:
                unit = LENGTH.usual
                columns |= {
                    unit.in_brackets(f"d{axis} of {link.link}{by}"): unit.factor * np.array(given_ways)[:, k]
                    for k, axis in enumerate("xyz")
                }
    return columns
