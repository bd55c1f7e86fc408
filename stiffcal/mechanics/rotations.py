"""Rotations, batched over the leading axes: rotation vectors, matrices, turns about fixed axes.

Rotation vectors are axis times angle, rad; a matrix ``R`` takes components from the turned axes to the fixed ones.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.quaternions import quaternion_from_rotation, vector_from_quaternion

# Below this squared angle the series of sin(x)/x and its kin are exact to rounding (next term x^6/5040 < 1e-19).
_SERIES_BELOW = 1e-4


def cross_matrix(vector: Floats) -> Floats:
    """Return the matrices of the cross product, ``cross_matrix(a) @ b = a × b``.

    Parameters
    ----------
    vector : (…, 3)

    Returns
    -------
    (…, 3, 3)
    """
    result = np.zeros((*vector.shape, 3))
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    result[..., 0, 1], result[..., 0, 2] = -z, y
    result[..., 1, 0], result[..., 1, 2] = z, -x
    result[..., 2, 0], result[..., 2, 1] = -y, x
    return result


def exponential_coefficients(squared_angle: Floats) -> tuple[Floats, Floats]:
    """Return sin(x)/x and (1 − cos x)/x² for x² given, exact at zero (Rodrigues' formula)."""
    series_a = 1.0 - squared_angle / 6.0 * (1.0 - squared_angle / 20.0)
    series_b = 0.5 - squared_angle / 24.0 * (1.0 - squared_angle / 30.0)
    small = squared_angle < _SERIES_BELOW
    # Deflections are always that small; trigonometry would be half the work of a sweep.
    if small.all():
        return series_a, series_b
    safe = np.where(small, 1.0, squared_angle)
    angle = np.sqrt(safe)
    half = np.sin(angle / 2.0)
    return np.where(small, series_a, np.sin(angle) / angle), np.where(small, series_b, 2.0 * half * half / safe)


def rotation_from_vector(vector: Floats) -> Floats:
    """Return the matrices exp([r]×) of rotation vectors (Rodrigues).

    Parameters
    ----------
    vector : (…, 3) rad.

    Returns
    -------
    (…, 3, 3)

    Examples
    --------
    >>> import numpy as np
    >>> np.round(rotation_from_vector(np.array([0.0, 0.0, np.pi / 2])) @ [1.0, 0.0, 0.0], 12).tolist()
    [0.0, 1.0, 0.0]
    """
    a, b = exponential_coefficients(np.sum(vector * vector, axis=-1))
    cross = cross_matrix(vector)
    return np.asarray(np.eye(3) + a[..., None, None] * cross + b[..., None, None] * (cross @ cross))


def vector_from_rotation(rotation: Floats) -> Floats:
    """Return the rotation vectors log(R) of matrices, |r| ≤ π.

    Goes by the quaternion, which keeps full precision both for the microradians of a deflection and close to half a
    turn.

    Parameters
    ----------
    rotation : (…, 3, 3)

    Returns
    -------
    (…, 3) rad.
    """
    return vector_from_quaternion(quaternion_from_rotation(rotation))


def rotation_from_rpy(rpy: Floats) -> Floats:
    """Return Rz(yaw) Ry(pitch) Rx(roll): turns about the *fixed* axes x, y, z in this order.

    Parameters
    ----------
    rpy : (…, 3) roll, pitch, yaw, rad.

    Returns
    -------
    (…, 3, 3)
    """
    x, y, z = np.eye(3)
    roll, pitch, yaw = rpy[..., 0:1], rpy[..., 1:2], rpy[..., 2:3]
    rotation = rotation_from_vector(yaw * z) @ rotation_from_vector(pitch * y) @ rotation_from_vector(roll * x)
    return np.asarray(rotation)


def rpy_from_rotation(rotation: Floats) -> Floats:
    """Return turns about the *fixed* axes x, y, z of rotation matrices, the inverse of `rotation_from_rpy`.

    At a pitch of ±90° roll and yaw turn about one axis: all of the turn is roll.

    Parameters
    ----------
    rotation : (…, 3, 3)

    Returns
    -------
    (…, 3) roll, pitch, yaw, rad, pitch within ±π/2.

    Examples
    --------
    >>> import numpy as np
    >>> rpy_from_rotation(rotation_from_rpy(np.array([[0.3, -0.2, 2.0], [0.4, np.pi / 2, 0.1]]))).round(9).tolist()
    [[0.3, -0.2, 2.0], [0.3, 1.570796327, 0.0]]
    """
    r = rotation
    across = np.hypot(r[..., 0, 0], r[..., 1, 0])
    upright = across <= 1e-9
    roll = np.where(upright, np.arctan2(-r[..., 1, 2], r[..., 1, 1]), np.arctan2(r[..., 2, 1], r[..., 2, 2]))
    yaw = np.where(upright, 0.0, np.arctan2(r[..., 1, 0], r[..., 0, 0]))
    return np.stack([roll, np.arctan2(-r[..., 2, 0], across), yaw], axis=-1)


def transform(rotation: Floats, translation: Floats) -> Floats:
    """Return the (4, 4) rigid transform of a (3, 3) rotation and a (3,) translation, m."""
    result = np.eye(4)
    result[:3, :3] = rotation
    result[:3, 3] = translation
    return result


def inverse_transform(rigid: Floats) -> Floats:
    """Return the inverse of rigid transforms (…, 4, 4)."""
    result = np.zeros_like(rigid)
    transposed = np.swapaxes(rigid[..., :3, :3], -1, -2)
    result[..., :3, :3] = transposed
    result[..., :3, 3] = -(transposed @ rigid[..., :3, 3:])[..., 0]
    result[..., 3, 3] = 1.0
    return result
