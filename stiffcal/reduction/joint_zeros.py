"""The zero of a joint with which displacements follow their loads best: by any angle, not only by quarter turns.

A controller's zero that is not the robot file's turns the joint's axis and all that stands beyond it, so that the
displacements of a table contradict the angles though nothing measures a place. What springs leave is a smooth
function of each zero: Gauss–Newton steps go from the best of four quarter turns to its least value.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.angle_conventions import QUARTERS, CountedAngles
from stiffcal.reduction.work_of_load import left_by_joints

# Of the numerical derivative; the longest step and the last one; rad.
STEP, LONGEST, LAST = 1e-5, 0.5, 1e-4
MOST_ROUNDS = 20


def other_zeros(states: LoadStates, chain: Chain) -> Iterator[CountedAngles]:
    """Yield the angles with the zero of each turning joint moved to where its springs leave the least.

    Parameters
    ----------
    states : load states whose displacements, not places, were measured. chain : the robot.
    """
    for joint, name in enumerate(chain.joint_names):
        if chain.prismatic[joint]:
            continue
        turn = (_best_turn(states, chain, joint) + np.pi) % (2.0 * np.pi) - np.pi
        yield CountedAngles(_turned(states.joints, joint, turn), InputChange(ChangeKind.ZERO, (name,), (float(turn),)))


def _best_turn(states: LoadStates, chain: Chain, joint: int) -> float:
    """Return by how much the joint's zero moves, rad; of a search that finds no end the best turn on its way."""

    def left(turn: float) -> Floats:
        return left_by_joints(replace(states, joints=_turned(states.joints, joint, turn)), chain)[0]

    turn = min(QUARTERS, key=lambda quarter: float(np.sum(left(quarter) ** 2)))
    here = left(turn)
    for _ in range(MOST_ROUNDS):
        slope = (left(turn + STEP) - here) / STEP
        steepness = float(slope @ slope)
        step = float(np.clip(-(slope @ here) / steepness, -LONGEST, LONGEST)) if steepness > 0.0 else 0.0
        there = left(turn + step)
        if abs(step) < LAST or there @ there >= here @ here:
            break
        turn, here = turn + step, there
    return float(turn)


def _turned(joints: Floats, joint: int, turn: float) -> Floats:
    angles = joints.copy()
    angles[:, joint] += turn
    return angles
