"""A force sensor that is turned on the flange otherwise than its frame states.

Joint springs explain the displacements of a sound campaign; under loads in wrong axes they explain less. Turns of the
sensor are three numbers more: an F test says whether they are needed, where springs leave much without them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector, rpy_from_rotation
from stiffcal.mistakes.displacements.springs import (
    BY_CHANCE,
    FOLLOWS,
    NOTHING_LEFT,
    count_poses,
    explained_by_joints,
)
from stiffcal.mistakes.some_rows import some_of

ANGLES = 3
STARTS = 3
"""Of the 24 right angles: half way between two of them a third one may be the best that leads nowhere."""


@dataclass(frozen=True)
class TurnedSensor:
    """How the sensor seems to be turned."""

    rpy_deg: tuple[float, float, float]
    """Of its axes in those of the body that it is fixed to, about fixed x, y, z, whole degrees."""
    turn_deg: float
    """From the axes that are stated."""
    declared: float
    """Share of the displacement that joint springs explain with the axes that are stated."""
    turned: float
    """And with these."""


def turned_sensor(states: LoadStates, chain: Chain) -> TurnedSensor | None:
    """Return how a force sensor is turned, where the displacements follow the loads only so; None otherwise.

    Parameters
    ----------
    states : used load states. Those whose force is in axes of the base are let pass.
    """
    on_robot = states.setup.wrench_axes.body > 0
    if len(states) == 0 or not on_robot or not states.setup.targets or not np.any(states.wrench):
        return None
    some = states.select(some_of(len(states)))
    declared = explained_by_joints(some, chain)
    if declared > FOLLOWS:
        return None
    from scipy.optimize import minimize
    from scipy.special import fdtrc

    # the three components of a pose as one reading each, as its states share what the model lacks
    free = 3 * count_poses(some) - chain.n_joints - ANGLES
    if free < 1:
        return None

    def left(turn: Floats) -> float:
        return 1.0 - explained_by_joints(some, chain, turn)

    tried = []
    for start in sorted(_right_angles(), key=left)[:STARTS]:

        def left_after(vector: Floats, start: Floats = start) -> float:
            return left(start @ rotation_from_vector(vector))

        found = minimize(left_after, np.zeros(ANGLES), method="Nelder-Mead")
        tried.append(start @ rotation_from_vector(found.x))
    turn = min(tried, key=left)
    best = max(left(turn), NOTHING_LEFT)
    ratio = (1.0 - declared - best) / ANGLES / (best / free)
    if 1.0 - best <= FOLLOWS or float(fdtrc(ANGLES, free, ratio)) > BY_CHANCE:
        return None
    axes = states.setup.wrench_axes.transform[:3, :3] @ turn
    roll, pitch, yaw = np.round(np.degrees(rpy_from_rotation(axes))) + 0.0
    angle = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))))
    return TurnedSensor((float(roll), float(pitch), float(yaw)), angle, declared, 1.0 - best)


def _right_angles() -> Iterator[Floats]:
    """Yield the 24 turns that bring the axes of a frame onto each other."""
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[range(3), order] = signs
            if np.linalg.det(turn) > 0.0:
                yield turn
