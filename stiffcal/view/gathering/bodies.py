"""What the robot's links look like on the page for a browser."""

from __future__ import annotations

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.robot.link_shapes import link_shapes
from stiffcal.errors import InputError
from stiffcal.meshes.client import read_bodies
from stiffcal.view.content import ViewBody

MOST_TRIANGLES = 6000
"""Of all bodies together: some 50 kB of a page that has 400, and more than a picture of 1000 pixels shows."""


def view_bodies(campaign: Campaign) -> tuple[list[ViewBody], str]:
    """Return the bodies that the shapes of the robot's URDF show, and why there are none; "" where nothing is wrong.

    Where a mesh cannot be used none is drawn: half a robot would look as if the rest were missing.
    """
    try:
        shapes = link_shapes(campaign.robot, campaign.folder, campaign.manifest.robot)
        if not shapes:
            return [], ""
        found = read_bodies(campaign.folder, shapes, MOST_TRIANGLES, str(campaign.robot.urdf))
    except InputError as error:
        return [], str(error.faults[0])
    return [
        ViewBody(body=body, points=surface.points, triangles=surface.triangles)
        for body, surface in sorted(found.items())
    ], ""
