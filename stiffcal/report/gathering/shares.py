"""What each place of the model contributes to the deflection, for the report's first page."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

from stiffcal.identification.answers.deflection_shares import deflection_shares
from stiffcal.identification.readings.observations import observe
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.report.content import PlaceShare

if TYPE_CHECKING:
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.stages.steps import Ingested


def place_shares(data: Ingested, identified: IdentifyResult) -> tuple[PlaceShare, ...]:
    """Return the share of each place in the predicted deflection, its effects together, largest first.

    Parameters
    ----------
    data : the campaign with its states. identified : the present fit.
    """
    robot = placed_robot(data.campaign).with_values(identified.robot_values())
    total: dict[tuple[str, str, int | None, bool], float] = defaultdict(float)
    for entry in deflection_shares(robot, observe(data.states, robot.chain)):
        place = entry.placed.place
        key: tuple[str, str, int | None, bool] = (place.label, place.label, None, False)
        if place.kind == "joints":
            key = (f"joint {place.joints[0]}", str(place.joints[0]), place.joints[0], False)
        elif place.kind == "links":
            key = (place.link, place.link, robot.chain.joint_of_link[place.link], True)
        total[key] += entry.share
    shares = [PlaceShare(label, mark, share, joint, beyond) for (label, mark, joint, beyond), share in total.items()]
    return tuple(sorted(shares, key=lambda place: -place.share))
