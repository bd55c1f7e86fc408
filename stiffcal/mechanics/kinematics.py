"""Forward kinematics and Jacobians of many states at once.

Why the state axis comes last inside: a (3, 3, n) stack is nine contiguous rows, so that every operation runs over long
rows instead of over millions of tiny matrices; work is done in blocks that stay in the processor's cache. Public
functions return the state axis first, as views.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import exponential_coefficients, vector_from_rotation

# States handled at once: a frame of 4096 states is 400 kB, so that what one step touches stays in the processor's cache
# while the interpreter's share stays small (measured: 2048 and 8192 are both slower).
BLOCK = 4096
# Below this sine four terms of the arc sine's series are exact to rounding.
SMALL_SINE = 0.01


@dataclass(frozen=True)
class StackedFrame:
    """n rigid frames with the state axis last."""

    rotation: Floats
    """(3, 3, n) base_from_frame."""
    position: Floats
    """(3, n) origin in base axes, m."""

    def states(self, pick: Integers) -> StackedFrame:
        """Return those of some states, any number of times each."""
        return StackedFrame(self.rotation[:, :, pick], self.position[:, pick])

    def moved(self, fixed: Floats) -> StackedFrame:
        """Return the frames ``self @ fixed`` for a constant rigid transform (4, 4)."""
        return StackedFrame(
            np.matmul(fixed[:3, :3].T, self.rotation),
            self.position + np.matmul(fixed[None, None, :3, 3], self.rotation)[:, 0],
        )

    def turned_about_z(self, angle: Floats) -> StackedFrame:
        """Return the frames turned about their own z axes by ``angle`` (n,), rad."""
        return self.turned_about_z_by(np.cos(angle), np.sin(angle))

    def turned_about_z_by(self, cosine: Floats, sine: Floats) -> StackedFrame:
        """Return the frames turned about their own z axes by angles of which cosine and sine (n,) are known."""
        x, y = self.rotation[:, 0], self.rotation[:, 1]
        rotation = np.empty_like(self.rotation)
        rotation[:, 0] = x * cosine + y * sine
        rotation[:, 1] = y * cosine - x * sine
        rotation[:, 2] = self.rotation[:, 2]
        return StackedFrame(rotation, self.position)

    def shifted_along_z(self, distance: Floats) -> StackedFrame:
        """Return the frames shifted along their own z axes by ``distance``, (n,) or one number, m."""
        return StackedFrame(self.rotation, self.position + distance * self.rotation[:, 2])

    def moved_by_joint(self, position: Floats, prismatic: bool) -> StackedFrame:
        """Return the frames behind a joint: turned by its angle (n,), rad, or shifted by its position (n,), m."""
        return self.shifted_along_z(position) if prismatic else self.turned_about_z(position)

    def displaced(self, small: Floats) -> StackedFrame:
        """Return the frames moved by (6, n) translations and rotation vectors in their own axes, m and rad."""
        position = self.position + from_frame(self.rotation, small[:3])
        x, y, z = small[3:]
        xx, yy, zz = x * x, y * y, z * z
        a, b = exponential_coefficients(xx + yy + zz)
        # The turn's own matrix, I + a [φ]× + b [φ]×², by its elements.
        turn = np.empty_like(self.rotation)
        turn[0, 0], turn[1, 1], turn[2, 2] = 1.0 - b * (yy + zz), 1.0 - b * (xx + zz), 1.0 - b * (xx + yy)
        for (i, j), mixed, single in (
            ((0, 1), b * x * y, a * z),
            ((2, 0), b * x * z, a * y),
            ((1, 2), b * y * z, a * x),
        ):
            turn[i, j], turn[j, i] = mixed - single, mixed + single
        rotation, term = np.empty_like(self.rotation), np.empty_like(self.position)
        for k in range(3):
            column = rotation[:, k]
            np.multiply(self.rotation[:, 0], turn[0, k], out=column)
            np.multiply(self.rotation[:, 1], turn[1, k], out=term)
            column += term
            np.multiply(self.rotation[:, 2], turn[2, k], out=term)
            column += term
        return StackedFrame(rotation, position)

    def point(self, offset: Floats) -> Floats:
        """Return the place (3, n), base axes, of a point given by its (3,) place in the frame, m."""
        return np.asarray(self.position + np.matmul(offset[None, None, :], self.rotation)[:, 0])


def turn_between(after: Floats, before: Floats) -> Floats:
    """Return the (3, n) rotation vectors of ``after @ beforeᵀ``, base axes, for (3, 3, n) stacks, rad."""
    sine = np.empty(after.shape[1:])
    for k, (i, j) in enumerate(((2, 1), (0, 2), (1, 0))):
        # twice the sine is the skew part of the product
        products = np.einsum("kn,kn->n", after[i], before[j]), np.einsum("kn,kn->n", after[j], before[i])
        sine[k] = 0.5 * (products[0] - products[1])
    squared = sine[0] * sine[0] + sine[1] * sine[1] + sine[2] * sine[2]
    trace = np.einsum("ikn,ikn->n", after, before)
    if np.any((squared > SMALL_SINE**2) | (trace < 2.0)):
        turn = np.moveaxis(np.einsum("ikn,jkn->ijn", after, before), -1, 0)
        finite = np.isfinite(trace)
        result = np.full(sine.shape, np.nan)
        result[:, finite] = vector_from_rotation(turn[finite]).T
        return result
    # angle / sin(angle), by its series
    return np.asarray(sine * (1.0 + squared * (1.0 / 6.0 + squared * (3.0 / 40.0 + squared * (5.0 / 112.0)))))


def cross(a: Floats, b: Floats) -> Floats:
    """Return a × b of (3, n) stacks."""
    result = np.empty_like(b)
    result[0] = a[1] * b[2] - a[2] * b[1]
    result[1] = a[2] * b[0] - a[0] * b[2]
    result[2] = a[0] * b[1] - a[1] * b[0]
    return result


def to_frame(rotation: Floats, vector: Floats) -> Floats:
    """Return Rᵀ v: components of (3, n) vectors in the axes of (3, 3, n) frames."""
    return np.asarray(rotation[0] * vector[0] + rotation[1] * vector[1] + rotation[2] * vector[2])


def from_frame(rotation: Floats, vector: Floats) -> Floats:
    """Return R v: base components of (3, n) vectors given in the axes of (3, 3, n) frames."""
    return np.asarray(rotation[:, 0] * vector[0] + rotation[:, 1] * vector[1] + rotation[:, 2] * vector[2])


def base_frame(n: int) -> StackedFrame:
    """Return the base frame, n times."""
    rotation = np.zeros((3, 3, n))
    rotation[(0, 1, 2), (0, 1, 2)] = 1.0
    return StackedFrame(rotation, np.zeros((3, n)))


def stacked_bodies(chain: Chain, angles: Floats) -> list[StackedFrame]:
    """Return the undeformed frames of all bodies: base, J joint frames, flange.

    Parameters
    ----------
    chain : J joints.
    angles : (J, n) model angles, rad.
    """
    frames = [base_frame(angles.shape[1])]
    for k, prismatic in enumerate(chain.prismatic):
        frames.append(frames[-1].moved(chain.fixed[k]).moved_by_joint(angles[k], bool(prismatic)))
    frames.append(frames[-1].moved(chain.flange))
    return frames


def body_poses(chain: Chain, angles: Floats) -> tuple[Floats, Floats]:
    """Return the poses of the undeformed bodies.

    Parameters
    ----------
    chain : J joints.
    angles : (n, J) model angles, rad.

    Returns
    -------
    positions : (n, J + 2, 3) origins in base axes, m: base, J joint frames, flange.
    rotations : (n, J + 2, 3, 3) base_from_body.
    """
    frames = stacked_bodies(chain, np.ascontiguousarray(angles.T))
    positions = np.stack([frame.position for frame in frames])
    rotations = np.stack([frame.rotation for frame in frames])
    return np.moveaxis(positions, -1, 0), np.moveaxis(rotations, -1, 0)


def attached_poses(chain: Chain, angles: Floats, attachment: Attachment) -> tuple[Floats, Floats]:
    """Return the undeformed pose of a frame that rides on a body.

    Parameters
    ----------
    angles : (n, J) model angles, rad.
    attachment : the body and the frame on it.

    Returns
    -------
    position : (n, 3) base axes, m.
    rotation : (n, 3, 3) base_from_frame.
    """
    frame = stacked_bodies(chain, np.ascontiguousarray(angles.T))[attachment.body].moved(attachment.transform)
    return np.moveaxis(frame.position, -1, 0), np.moveaxis(frame.rotation, -1, 0)


def jacobians(chain: Chain, angles: Floats, attachment: Attachment) -> Floats:
    """Return the geometric Jacobians of a point on a body, base axes.

    Column k is (z_k × (p − o_k), z_k), of a prismatic joint (z_k, 0); zero for joints outboard of the body (Wang, Zhang
    and Fuhlbrigge 2009, eq. 3; Siciliano et al. 2009, eq. 3.30).

    Parameters
    ----------
    chain : J joints.
    angles : (n, J) model angles, rad.
    attachment : the body and the frame whose origin is the point.

    Returns
    -------
    (n, 6, J) m/rad over rad/rad, of a prismatic joint m/m over rad/m; a view whose memory has the state axis last.
    """
    n, n_joints = angles.shape
    moving = min(attachment.body, n_joints)
    result = np.empty((6, n_joints, n))
    result[:, moving:] = 0.0
    outward = [np.ascontiguousarray(fixed.T) for fixed in chain.fixed[:moving]]
    placed = attachment.transform if attachment.body <= n_joints else chain.flange @ attachment.transform
    for start in range(0, n, BLOCK):
        block = slice(start, min(start + BLOCK, n))
        _jacobian_block(outward, placed[:3, 3], angles[block], chain.prismatic, result[:, :moving, block])
    return np.moveaxis(result, -1, 0)


def _jacobian_block(outward: list[Floats], point: Floats, angles: Floats, prismatic: Booleans, result: Floats) -> None:
    """Fill (6, K, n) for K joints; frames stand as columns x, y, z, origin (4, 3, n), moved by one product.

    Parameters
    ----------
    outward : K transposed transforms (4, 4) from one joint frame to the next.
    point : (3,) in the last of these frames, m.
    angles : (n, J) model angles, rad.
    prismatic : (J,) True where the angle is a length along z, m.
    result : filled in place.
    """
    moving, n = result.shape[1:]
    # Cosine and sine from one tangent: the trigonometry is a third of the work. At half a turn the tangent is 1.6e16,
    # which gives both to rounding.
    half = np.tan(0.5 * np.ascontiguousarray(angles[:, :moving].T))
    square = half * half
    shrink = 1.0 / (1.0 + square)
    cosine, sine = (1.0 - square) * shrink, 2.0 * half * shrink
    frame, fixed_frame, term = np.zeros((4, 3, n)), np.empty((4, 3, n)), np.empty((3, n))
    frame[(0, 1, 2), (0, 1, 2)] = 1.0
    arm = np.empty((3, moving, n))
    for k in range(moving):
        np.matmul(outward[k], frame.reshape(4, -1), out=fixed_frame.reshape(4, -1))
        if prismatic[k]:
            frame[:] = fixed_frame
            np.multiply(fixed_frame[2], angles[:, k], out=term)
            frame[3] += term
            arm[:, k], result[3:, k] = fixed_frame[3], fixed_frame[2]
            continue
        np.multiply(fixed_frame[0], cosine[k], out=frame[0])
        np.multiply(fixed_frame[1], sine[k], out=term)
        frame[0] += term
        np.multiply(fixed_frame[1], cosine[k], out=frame[1])
        np.multiply(fixed_frame[0], sine[k], out=term)
        frame[1] -= term
        frame[2:] = fixed_frame[2:]
        arm[:, k], result[3:, k] = fixed_frame[3], fixed_frame[2]
    np.subtract((np.append(point, 1.0) @ frame.reshape(4, -1)).reshape(3, 1, n), arm, out=arm)
    axis, product = result[3:], np.empty((moving, n))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(axis[j], arm[k], out=result[i])
        np.multiply(axis[k], arm[j], out=product)
        result[i] -= product
    for joint in np.flatnonzero(prismatic[:moving]):
        result[:3, joint], result[3:, joint] = axis[:, joint], 0.0
