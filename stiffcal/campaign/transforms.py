"""Rigid transforms as the user writes them, turned into matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.typed import Placement

Numbers: TypeAlias = Sequence[float] | Floats


def translation(xyz: Numbers) -> Floats:
    """Return the (4, 4) transform that moves by `xyz`, m."""
    transform = np.eye(4)
    transform[:3, 3] = xyz
    return transform


def rotation_rpy(rpy: Numbers) -> Floats:
    """Return the (3, 3) rotation by turns about fixed x, y, z in this order, rad: Rz(yaw) Ry(pitch) Rx(roll).

    Examples
    --------
    >>> rotation_rpy([0, 0, np.pi / 2]).round(6)[:, 0].tolist()
    [0.0, 1.0, 0.0]
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_z @ about_y @ about_x)


def rotation_quaternion(quaternion: Numbers) -> Floats:
    """Return the (3, 3) rotation of a quaternion w, x, y, z, normalised."""
    w, x, y, z = np.asarray(quaternion, dtype=float) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def screw_x(a: float, alpha: float) -> Floats:
    """Return the (4, 4) transform along x by `a`, m, and about x by `alpha`, rad."""
    transform = translation((a, 0.0, 0.0))
    transform[:3, :3] = rotation_rpy((alpha, 0.0, 0.0))
    return transform


def rotation_taking_z_to(axis: Numbers) -> Floats:
    """Return the (4, 4) shortest rotation that takes z to `axis`; for −z, half a turn about x.

    The quaternion (1 + z·a, z × a), normalised.

    Examples
    --------
    >>> rotation_taking_z_to([0.0, 2.0, 0.0])[:3, 2].round(9).tolist()
    [0.0, 1.0, 0.0]
    """
    direction = np.asarray(axis, dtype=float) / np.max(np.abs(axis))  # squares of 1e-300 and of 1e300 are no numbers
    x, y, z = direction / np.linalg.norm(direction)
    across = x * x + y * y
    if z < 0 and across < 1e-24:
        rotation = np.diag([1.0, -1.0, -1.0])
    else:
        rotation = rotation_quaternion((across / (1.0 - z) if z < 0 else 1.0 + z, -y, x, 0.0))  # 1 + z, no cancelling
    transform = np.eye(4)
    transform[:3, :3] = rotation
    return transform


def placement_matrix(placement: Placement) -> Floats:
    """Return the (4, 4) parent_from_frame transform; a rotation printed with few digits is made exact."""
    transform = translation(placement.xyz_m)
    if placement.quaternion_wxyz is not None:
        transform[:3, :3] = rotation_quaternion(placement.quaternion_wxyz)
    elif placement.rpy_deg is not None:
        transform[:3, :3] = rotation_rpy(np.deg2rad(placement.rpy_deg))
    elif placement.matrix is not None:
        left, _, right = np.linalg.svd(np.array(placement.matrix))
        transform[:3, :3] = left @ right
    return transform
