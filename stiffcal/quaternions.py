"""Unit quaternions (w, x, y, z), batched over the leading axes; the only code of them.

A quaternion and its negative are one rotation; functions that make one from a matrix return w ≥ 0. NaN stays NaN.
SciPy's ``Rotation`` would do; importing it takes longer than most commands, and it refuses NaN.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats

# Below this sine of half the angle, angle / sine is 2 to rounding.
_TINY = 1e-12


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
    w, x, y, z = np.moveaxis(q / np.sqrt(np.sum(q * q, axis=-1, keepdims=True)), -1, 0)
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def vector_from_quaternion(quaternion: Floats) -> Floats:
    """Return the rotation vectors of unit quaternions with w ≥ 0, |r| ≤ π.

    Parameters
    ----------
    quaternion : (…, 4)

    Returns
    -------
    (…, 3) rad.
    """
    imaginary = quaternion[..., 1:]
    sine = np.sqrt(np.sum(imaginary * imaginary, axis=-1, keepdims=True))
    angle = 2.0 * np.arctan2(sine, quaternion[..., :1])
    # angle / sin(angle/2) → 2 at zero
    return np.asarray(imaginary * np.where(sine > _TINY, angle / np.where(sine > _TINY, sine, 1.0), 2.0))


def quaternion_product(a: Floats, b: Floats) -> Floats:
    """Return a ∘ b of quaternions (…, 4), scalar first (Li et al. 2019, paper 003, eq. 7)."""
    w, x, y, z = (a[..., k] for k in range(4))
    s, t, u, v = (b[..., k] for k in range(4))
    rows = (
        w * s - x * t - y * u - z * v,
        w * t + x * s + y * v - z * u,
        w * u - x * v + y * s + z * t,
        w * v + x * u - y * t + z * s,
    )
    return np.stack(rows, axis=-1)


def conjugate(quaternion: Floats) -> Floats:
    """Return (…, 4) the inverse of unit quaternions."""
    return np.asarray(quaternion * np.array([1.0, -1.0, -1.0, -1.0]))
