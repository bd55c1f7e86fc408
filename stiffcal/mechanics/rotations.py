"""Rotations, batched over the leading axes: rotation vectors, matrices, unit quaternions (w, x, y, z).

Rotation vectors are axis times angle, rad; a matrix ``R`` takes components from the turned axes to the fixed ones.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats

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
    quaternion = quaternion_from_rotation(rotation)
    imaginary = quaternion[..., 1:]
    sine = np.sqrt(np.sum(imaginary * imaginary, axis=-1))
    angle = 2.0 * np.arctan2(sine, quaternion[..., 0])
    # angle / sin(angle/2) → 2 at zero
    scale = np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)
    return np.asarray(imaginary * scale[..., None])


def quaternion_from_rotation(rotation: Floats) -> Floats:
    """Return unit quaternions (w, x, y, z), w ≥ 0, of rotation matrices.

    Of the four classical formulas the one with the largest divisor is taken for each matrix (Shepperd, 1978).

    Parameters
    ----------
    rotation : (…, 3, 3)

    Returns
    -------
    (…, 4)
    """
    r = np.asarray(rotation, dtype=np.float64)
    xx, yy, zz = r[..., 0, 0], r[..., 1, 1], r[..., 2, 2]
    x, y, z = r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]
    xy, xz, yz = r[..., 0, 1] + r[..., 1, 0], r[..., 0, 2] + r[..., 2, 0], r[..., 1, 2] + r[..., 2, 1]
    # Each row holds 4 × (component product) for one choice of the leading component.
    rows = (
        (1 + xx + yy + zz, x, y, z),
        (x, 1 + xx - yy - zz, xy, xz),
        (y, xy, 1 - xx + yy - zz, yz),
        (z, xz, yz, 1 - xx - yy + zz),
    )
    candidates = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    leading = np.argmax(np.diagonal(candidates, axis1=-2, axis2=-1), axis=-1)
    chosen = np.take_along_axis(candidates, leading[..., None, None], axis=-2)[..., 0, :]
    chosen = chosen / np.sqrt(np.sum(chosen * chosen, axis=-1, keepdims=True))
    return np.asarray(np.where(chosen[..., :1] < 0, -chosen, chosen))


def rotation_from_quaternion(quaternion: Floats) -> Floats:
    """Return rotation matrices of quaternions (w, x, y, z), which are scaled to unit length.

    Parameters
    ----------
    quaternion : (…, 4)

    Returns
    -------
    (…, 3, 3)
    """
    q = np.asarray(quaternion, dtype=np.float64)
    q = q / np.sqrt(np.sum(q * q, axis=-1, keepdims=True))
    w, v = q[..., 0], q[..., 1:]
    cross = cross_matrix(v)
    return np.asarray(np.eye(3) + 2.0 * w[..., None, None] * cross + 2.0 * (cross @ cross))


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
    turned = rotation_from_vector(yaw * z) @ rotation_from_vector(pitch * y) @ rotation_from_vector(roll * x)
    return np.asarray(turned)


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
