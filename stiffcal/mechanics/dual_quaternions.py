"""Poses and pose errors as unit dual quaternions (Li et al. 2019, paper 003, sections 2 and 4), batched.

A dual quaternion is eight numbers: real part (w, x, y, z), then dual part (w, x, y, z). A pose with rotation r and
position p is r + ε ½ p r, so that it stands for the turn first and the shift after it, in base axes. It has no singular
orientation, unlike the three angles that a controller shows; r and −r are one orientation, and functions that return
poses or errors give the one whose scalar part is not negative.

The state axis comes first and the eight components last, as in `stiffcal.quaternions`.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.quaternions import (
    conjugate,
    quaternion_from_rotation,
    quaternion_product,
    vector_from_quaternion,
)


def dual_product(a: Floats, b: Floats) -> Floats:
    """Return a ∘ b of dual quaternions (…, 8) (003, eq. 6): for poses, b expressed in a.

    Examples
    --------
    >>> import numpy as np
    >>> lift = dual_from_pose(np.array([0.0, 0.0, 1.0]), np.eye(3))
    >>> position_of_dual(dual_product(lift, lift)).tolist()
    [0.0, 0.0, 2.0]
    """
    real = quaternion_product(a[..., :4], b[..., :4])
    dual = quaternion_product(a[..., :4], b[..., 4:]) + quaternion_product(a[..., 4:], b[..., :4])
    return np.concatenate([real, dual], axis=-1)


def dual_conjugate(a: Floats) -> Floats:
    """Return (…, 8) both parts conjugated: the inverse of a unit dual quaternion."""
    return np.asarray(a * np.array([1.0, -1.0, -1.0, -1.0, 1.0, -1.0, -1.0, -1.0]))


def dual_from_pose(position: Floats, rotation: Floats) -> Floats:
    """Return unit dual quaternions of poses.

    Parameters
    ----------
    position : (…, 3) m.
    rotation : (…, 3, 3).

    Returns
    -------
    (…, 8) real part without unit, dual part in m.
    """
    return dual_from_quaternion(position, quaternion_from_rotation(rotation))


def dual_from_quaternion(position: Floats, quaternion: Floats) -> Floats:
    """Return unit dual quaternions (…, 8) of positions (…, 3), m, and unit quaternions (…, 4), scalar first."""
    return np.concatenate([quaternion, 0.5 * quaternion_product(_pure(position), quaternion)], axis=-1)


def position_of_dual(dual: Floats) -> Floats:
    """Return positions (…, 3) = 2 d r*, m, of unit dual quaternions (…, 8)."""
    return np.asarray(2.0 * quaternion_product(dual[..., 4:], conjugate(dual[..., :4]))[..., 1:])


def pose_error(nominal: Floats, actual: Floats) -> Floats:
    """Return Δq̂ = p̂ ∘ q̂⁻¹ (003, eq. 36): the motion, in base axes, that takes the actual pose to the nominal one.

    With the deflected pose as the actual one this is the correction, the inverse of the deflection.

    Parameters
    ----------
    nominal, actual : (…, 8) unit dual quaternions.

    Returns
    -------
    (…, 8) unit, scalar part not negative.
    """
    error = dual_product(nominal, dual_conjugate(actual))
    return np.asarray(np.where(error[..., :1] < 0.0, -error, error))


def displacement_of_duals(after: Floats, before: Floats) -> Floats:
    """Return (…, 6): difference of positions, m, and rotation vector of R R_beforeᵀ, rad, base axes.

    The same six numbers as the displacements of `stiffcal.model.balance.equilibrium`. They are the position error ΔP
    and the orientation error ΔO of 003, eq. 48 to 50, with ΔO as the vector of the turn between the two orientations: a
    difference of three angles would depend on their order and blow up at the singular ones.

    Parameters
    ----------
    after, before : (…, 8) unit dual quaternions.
    """
    turn = pose_error(after, before)[..., :4]
    return np.concatenate([position_of_dual(after) - position_of_dual(before), vector_from_quaternion(turn)], axis=-1)


def displacement_map(dual: Floats) -> Floats:
    """Return (…, 8, 6) L with δq̂ = L (δp, δφ): the exact linear map from small displacements, base axes.

    Its left inverse is `displacement_from_change`; weights go over by W₈ = Pᵀ W₆ P.
    """
    result = np.zeros((*dual.shape, 6))
    # δr = ½ φ r, δd = ½ δp r + ½ p δr, and ½ φ r = ½ [r⁻] φ.
    turn = 0.5 * _right(dual[..., :4])[..., :, 1:]
    result[..., :4, 3:] = turn
    result[..., 4:, :3] = turn
    result[..., 4:, 3:] = 0.5 * _left(_pure(position_of_dual(dual))) @ turn
    return result


def displacement_from_change(dual: Floats) -> Floats:
    """Return (…, 6, 8) P with (δp, δφ) = P δq̂ for changes along unit dual quaternions; P L = 1, linear in ``dual``."""
    result = np.zeros((*dual.shape[:-1], 6, 8))
    # φ = 2 δr r*; δp = 2 (δd r* + d δr*), with δr* the conjugate of δr.
    result[..., 3:, :4] = 2.0 * _right(conjugate(dual[..., :4]))[..., 1:, :]
    result[..., :3, 4:] = 2.0 * _right(conjugate(dual[..., :4]))[..., 1:, :]
    result[..., :3, :4] = 2.0 * (_left(dual[..., 4:]) * np.array([1.0, -1.0, -1.0, -1.0]))[..., 1:, :]
    return result


def dual_chain(chain: Chain, angles: Floats) -> Floats:
    """Return the bodies' poses as products of dual quaternions (003, eq. 8).

    Parameters
    ----------
    chain : J joints.
    angles : (n, J) model angles, rad.

    Returns
    -------
    (n, J + 2, 8) base, J joint frames, flange.
    """
    n = len(angles)
    frames = [np.tile(np.eye(8)[0], (n, 1))]
    for k in range(chain.n_joints):
        fixed = dual_from_pose(chain.fixed[k, :3, 3], chain.fixed[k, :3, :3])
        turn = np.zeros((n, 8))
        # eq. 12: cos(θ/2) + sin(θ/2) k
        turn[:, 0], turn[:, 3] = np.cos(0.5 * angles[:, k]), np.sin(0.5 * angles[:, k])
        frames.append(dual_product(frames[-1], dual_product(np.broadcast_to(fixed, (n, 8)), turn)))
    flange = dual_from_pose(chain.flange[:3, 3], chain.flange[:3, :3])
    frames.append(dual_product(frames[-1], np.broadcast_to(flange, (n, 8))))
    return np.stack(frames, axis=1)


def attached_duals(frames: Floats, attachment: Attachment) -> Floats:
    """Return the poses (n, 8) of a frame that rides on a body, from the bodies' (n, J + 2, 8)."""
    placed = dual_from_pose(attachment.transform[:3, 3], attachment.transform[:3, :3])
    return dual_product(frames[:, attachment.body], np.broadcast_to(placed, (len(frames), 8)))


def joint_lines(frames: Floats) -> Floats:
    """Return the joints' axes as dual vectors l̂ = q̂ ∘ k ∘ q̂⁻¹, (n, J, 8): direction, and moment about the origin.

    Parameters
    ----------
    frames : (n, J + 2, 8) of `dual_chain`.
    """
    joints = frames[:, 1:-1]
    axis = np.zeros(8)
    axis[3] = 1.0
    return dual_product(joints, dual_product(np.broadcast_to(axis, joints.shape), dual_conjugate(joints)))


def dual_jacobian(frames: Floats, attachment: Attachment) -> Floats:
    """Return ∂q̂/∂θ of a frame on a body, (n, 8, J) (003, eq. 10 and 11): ½ l̂ᵢ ∘ q̂; zero for joints outboard.

    Parameters
    ----------
    frames : (n, J + 2, 8) of `dual_chain`.
    attachment : the body and the frame on it.
    """
    place = attached_duals(frames, attachment)
    lines = joint_lines(frames)
    columns = 0.5 * dual_product(lines, np.broadcast_to(place[:, None], lines.shape))
    columns[:, attachment.body :] = 0.0
    return np.swapaxes(columns, 1, 2)


def dual_hessian(frames: Floats, attachment: Attachment) -> Floats:
    """Return ∂²q̂/∂θᵢ∂θⱼ of a frame on a body, (n, J, J, 8): ¼ l̂ᵢ ∘ l̂ⱼ ∘ q̂ for i inboard of j (003, eq. 27).

    Parameters
    ----------
    frames : (n, J + 2, 8) of `dual_chain`.
    attachment : the body and the frame on it.
    """
    lines = joint_lines(frames)
    n, count = lines.shape[:2]
    slopes = np.swapaxes(dual_jacobian(frames, attachment), 1, 2)
    result = np.zeros((n, count, count, 8))
    for j in range(count):
        inboard = 0.5 * dual_product(lines[:, : j + 1], np.broadcast_to(slopes[:, None, j], (n, j + 1, 8)))
        result[:, : j + 1, j] = inboard
        result[:, j, : j + 1] = inboard
    return result


def _pure(vector: Floats) -> Floats:
    return np.concatenate([np.zeros_like(vector[..., :1]), vector], axis=-1)


def _left(a: Floats) -> Floats:
    """Return (…, 4, 4) [a⁺] with [a⁺] b = a ∘ b (003, eq. 42)."""
    w, x, y, z = (a[..., k] for k in range(4))
    rows = ((w, -x, -y, -z), (x, w, -z, y), (y, z, w, -x), (z, -y, x, w))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _right(a: Floats) -> Floats:
    """Return (…, 4, 4) [a⁻] with [a⁻] b = b ∘ a (003, eq. 43)."""
    w, x, y, z = (a[..., k] for k in range(4))
    rows = ((w, -x, -y, -z), (x, w, z, -y), (y, -z, w, x), (z, y, -x, w))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
