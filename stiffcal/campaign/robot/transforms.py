"""Rigid transforms as the user writes them, turned into matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.toml.typed import Placement
from stiffcal.mechanics.rotations import rotation_from_rpy
from stiffcal.quaternions import rotation_from_quaternion

Numbers: TypeAlias = Sequence[float] | Floats


def turned_about_z(angle: float) -> Floats:
    """Return a turn about z as a (4, 4) transform; ``angle`` in rad."""
    result = np.eye(4)
    result[:3, :3] = rotation_from_rpy(np.array([0.0, 0.0, angle]))
    return result


def translation(xyz: Numbers) -> Floats:
    """Return the (4, 4) transform that moves by `xyz`, m."""
    transform = np.eye(4)
    transform[:3, 3] = xyz
    return transform


def screw_x(a: float, alpha: float) -> Floats:
    """Return the (4, 4) transform along x by `a`, m, and about x by `alpha`, rad."""
    transform = translation((a, 0.0, 0.0))
    transform[:3, :3] = rotation_from_rpy(np.array([alpha, 0.0, 0.0]))
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
        scalar = across / (1.0 - z) if z < 0 else 1.0 + z  # 1 + z, no cancelling
        rotation = rotation_from_quaternion(np.array([scalar, -y, x, 0.0]))
    transform = np.eye(4)
    transform[:3, :3] = rotation
    return transform


def placement_matrix(placement: Placement) -> Floats:
    """Return the (4, 4) parent_from_frame transform; a rotation printed with few digits is made exact."""
    transform = translation(placement.xyz_m)
    if placement.quaternion_wxyz is not None:
        transform[:3, :3] = rotation_from_quaternion(np.asarray(placement.quaternion_wxyz))
    elif placement.rpy_deg is not None:
        transform[:3, :3] = rotation_from_rpy(np.deg2rad(placement.rpy_deg))
    elif placement.matrix is not None:
        left, _, right = np.linalg.svd(np.array(placement.matrix))
        transform[:3, :3] = left @ right
    return transform
