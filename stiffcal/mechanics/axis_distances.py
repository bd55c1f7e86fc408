"""How consecutive joint axes lie to each other: what identifies a robot's type, whatever convention describes it."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain

# A calibrated geometry differs from the drawing by a few millimetres and tenths of a degree, another robot by more.
SAME_LENGTH = 0.02
"""m, most difference of a distance between two axes of one robot."""
SAME_ANGLE = np.deg2rad(3.0)
"""rad, most difference of an angle between two axes of one robot; below it, two axes count as parallel."""


def distances_and_angles(chain: Chain) -> tuple[Floats, Floats]:
    """Return the distance and the angle between each joint axis and the next.

    Neither depends on the zero of an angle, on the sense of a joint, or on where along its axis a frame has its origin.

    Returns
    -------
    distance : (J-1,) m, along the common normal. angle : (J-1,) rad, from 0 to π/2.
    """
    origin, direction = chain.fixed[1:, :3, 3], chain.fixed[1:, :3, 2]
    cosine = np.clip(np.abs(direction[:, 2]), 0.0, 1.0)
    angle = np.arccos(cosine)
    across = np.hypot(origin[:, 0], origin[:, 1])
    normal = np.cross(np.array([0.0, 0.0, 1.0]), direction)
    length = np.linalg.norm(normal, axis=1)
    between_skew = np.abs(np.einsum("ki,ki->k", origin, normal)) / np.where(length > 0.0, length, 1.0)
    return np.where(angle < SAME_ANGLE, across, between_skew), angle


def first_difference(first: Chain, second: Chain) -> int | None:
    """Return the first joint k = 1 … J-1 whose axis lies otherwise to that of joint k + 1; None for one type of robot.

    Parameters
    ----------
    first, second : with the same number of joints.
    """
    lengths, angles = zip(distances_and_angles(first), distances_and_angles(second), strict=True)
    other = (np.abs(lengths[0] - lengths[1]) > SAME_LENGTH) | (np.abs(angles[0] - angles[1]) > SAME_ANGLE)
    return int(np.argmax(other)) + 1 if other.any() else None
