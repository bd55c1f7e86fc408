"""Clamped runs of several joints: each joint's states are searched apart, as they share no parameter with the others'.

With the output locked, the reading of a driven motor depends on the torque of its own drive. What the other joints
give only moves the lever arms of the fixture's wrench, by the thousandth part: they act with their identified values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans
from stiffcal.diagnosis.candidates import driven_joint_of_state
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.composite import CompliantRobot


@dataclass(frozen=True)
class DrivePart:
    """The clamped runs of one joint."""

    joint: int
    """The driven joint, from 1."""
    chosen: Booleans
    """(n,) True for its states."""
    robot: CompliantRobot
    """The model's effects at this joint and of the set-up; those of other joints in the background."""


def drive_parts(states: LoadStates, robot: CompliantRobot, values: Mapping[str, float]) -> list[DrivePart]:
    """Return the parts of a campaign; none where other runs than clamped ones are in it, or one joint alone was driven.

    Parameters
    ----------
    states : the campaign's load states.
    robot : the model.
    values : identified values by full name, with which other joints act.
    """
    if not len(states) or not states.clamped.all():
        return []
    driven = driven_joint_of_state(states, robot.chain)
    joints = np.unique(driven).tolist()
    if len(joints) < 2:
        return []
    known = robot.with_values(values)
    parts = []
    for joint in joints:
        own = [placed.place.joints in ((), (joint,)) and not placed.place.link for placed in robot.placed]
        parts.append(
            DrivePart(
                joint,
                driven == joint,
                replace(
                    robot,
                    placed=tuple(placed for placed, is_own in zip(robot.placed, own, strict=True) if is_own),
                    background=tuple(placed for placed, is_own in zip(known.placed, own, strict=True) if not is_own),
                ),
            )
        )
    return parts
