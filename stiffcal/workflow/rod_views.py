"""What the rods of a campaign can and cannot see, for `check`: sensible before anything is measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.measurements.load_states import MeasurementSetup


def rod_views(campaign: Campaign, setup: MeasurementSetup) -> list[dict[str, Any]]:
    """Return one view per link with rods."""
    import numpy as np

    from stiffcal.planning.rods import rods_can_see

    views = []
    for rods, shape in zip(setup.rods, setup.beams, strict=True):
        own_name = campaign.chain.link_names[campaign.chain.beams[rods.link].joint - 1]
        entry = campaign.robot.links.get(rods.link) or campaign.robot.links.get(own_name)
        drawn = None if entry is None or entry.section is None else entry.section.outline
        view = rods_can_see(rods, shape, None if drawn is None else [np.array(corner) for corner in drawn])
        views.append(
            {
                "link": view.link,
                "rods": list(view.rods),
                "carried": list(view.carried),
                "blind": list(view.blind),
                "spare": view.spare,
                "says": list(view.sentences),
            }
        )
    return views
