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
from stiffcal.identification.search_subject import SearchSubject
from stiffcal.identification.state_kinds import kinds_of_states
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
    subject: SearchSubject
    """What is searched, in words."""


def drive_parts(states: LoadStates, robot: CompliantRobot, values: Mapping[str, float]) -> list[DrivePart]:
    """Return the parts of a campaign; none where states of another kind are in it, or one joint alone was driven.

    Parameters
    ----------
    states : the campaign's load states.
    robot : the model.
    values : identified values by full name, with which other joints act.
    """
    subjects = {kind.subject for kind, _ in kinds_of_states(states)}
    subject = subjects.pop() if len(subjects) == 1 else None
    if subject is None:
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
                subject,
            )
        )
    return parts
