"""The links of a URDF that ride on the base or on a joint of the chain, and their places on it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.transforms import rotation_taking_z_to, translation
from stiffcal.campaign.robot.urdf.chain import UrdfRobot
from stiffcal.campaign.robot.urdf.elements import UrdfJoint, UrdfLink
from stiffcal.mechanics.rotations import rotation_from_rpy


def joint_origin(joint: UrdfJoint) -> Floats:
    """Return the (4, 4) transform from the parent link to the joint at zero, m."""
    transform = translation(joint.xyz)
    transform[:3, :3] = rotation_from_rpy(np.asarray(joint.rpy))
    return transform


def riding_links(urdf: UrdfRobot, joint: UrdfJoint | None) -> Iterator[tuple[UrdfLink, Floats]]:
    """Yield the links that ride on a joint of the chain up to its next one, each once, with its place.

    What branches off the chain counts at its zero position.

    Parameters
    ----------
    joint : a moving joint of the chain; None: the base.

    Yields
    ------
    The link, and the (4, 4) transform from its frame to that of the joint, whose z lies along the axis, or the base's.
    """
    on_path = {moving.name for moving in urdf.moving}
    counted: set[str] = set()
    waiting = [(urdf.base, np.eye(4)) if joint is None else (joint.child, rotation_taking_z_to(joint.axis).T)]
    while waiting:
        name, place = waiting.pop()
        if name in counted:  # the far end of a loop that hangs on this link
            continue
        counted.add(name)
        yield urdf.links[name], place
        waiting += [
            (below.child, place @ joint_origin(below))
            for below in urdf.children.get(name, ())
            if below.name not in on_path
        ]
