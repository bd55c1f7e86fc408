"""What the robot's links look like on the page for a browser."""

from __future__ import annotations

from stiffcal.campaign.link_meshes import link_meshes
from stiffcal.campaign.loading import Campaign
from stiffcal.errors import InputError
from stiffcal.meshes.client import read_bodies
from stiffcal.view.content import ViewBody

MOST_TRIANGLES = 6000
"""Of all bodies together: some 50 kB of a page that has 400, and more than a picture of 1000 pixels shows."""


def view_bodies(campaign: Campaign) -> tuple[list[ViewBody], str]:
    """Return the bodies that the meshes of the robot's URDF show, and why there are none; "" where nothing is wrong.

    Of meshes that cannot be used none is drawn: half a robot would look as if the rest were missing.
    """
    try:
        meshes = link_meshes(campaign.robot, campaign.folder, campaign.manifest.robot)
        if not meshes:
            return [], ""
        found = read_bodies(campaign.folder, meshes, MOST_TRIANGLES, str(campaign.robot.urdf))
    except InputError as error:
        return [], str(error.faults[0])
    return [
        ViewBody(body=body, points=surface.points, triangles=surface.triangles)
        for body, surface in sorted(found.items())
    ], ""
