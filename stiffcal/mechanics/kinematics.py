"""Forward kinematics and Jacobians of many states at once.

Why the state axis comes last inside: a (3, 3, n) stack is nine contiguous rows, so that every operation runs over long
rows instead of over millions of tiny matrices; work is done in blocks that stay in the processor's cache. Public
functions return the state axis first, as views.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import exponential_coefficients

Floats = NDArray[np.float64]

# States handled at once: a frame of 2048 states is 200 kB, so that what one step touches stays in a core's cache while
# the interpreter's share stays small (measured: 1024 and 4096 are both slower).
BLOCK = 2048


@dataclass(frozen=True)
class StackedFrame:
    """n rigid frames with the state axis last.

    Attributes
    ----------
    rotation : (3, 3, n) base_from_frame.
    position : (3, n) origin in base axes, m.
    """

    rotation: Floats
    position: Floats

    def moved(self, fixed: Floats) -> StackedFrame:
        """Return the frames ``self @ fixed`` for a constant rigid transform (4, 4)."""
        return StackedFrame(
            np.matmul(fixed[:3, :3].T, self.rotation),
            self.position + np.matmul(fixed[None, None, :3, 3], self.rotation)[:, 0],
        )

    def turned_about_z(self, angle: Floats) -> StackedFrame:
        """Return the frames turned about their own z axes by ``angle`` (n,), rad."""
        cosine, sine = np.cos(angle), np.sin(angle)
        x, y = self.rotation[:, 0], self.rotation[:, 1]
        rotation = np.empty_like(self.rotation)
        rotation[:, 0] = x * cosine + y * sine
        rotation[:, 1] = y * cosine - x * sine
        rotation[:, 2] = self.rotation[:, 2]
        return StackedFrame(rotation, self.position)

    def displaced(self, small: Floats) -> StackedFrame:
        """Return the frames moved by (6, n) translations and rotation vectors in their own axes, m and rad."""
        position = self.position + from_frame(self.rotation, small[:3])
        phi = small[3:]
        a, b = exponential_coefficients(phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2])
        once = _times_cross(self.rotation, phi)
        return StackedFrame(self.rotation + a * once + b * _times_cross(once, phi), position)

    def point(self, offset: Floats) -> Floats:
        """Return the place (3, n), base axes, of a point given by its (3,) place in the frame, m."""
        return np.asarray(self.position + np.matmul(offset[None, None, :], self.rotation)[:, 0])


def _times_cross(rotation: Floats, phi: Floats) -> Floats:
    """Return R [φ]× for (3, 3, n) and (3, n)."""
    result = np.empty_like(rotation)
    result[:, 0] = rotation[:, 1] * phi[2] - rotation[:, 2] * phi[1]
    result[:, 1] = rotation[:, 2] * phi[0] - rotation[:, 0] * phi[2]
    result[:, 2] = rotation[:, 0] * phi[1] - rotation[:, 1] * phi[0]
    return result


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
    for k in range(chain.n_joints):
        frames.append(frames[-1].moved(chain.fixed[k]).turned_about_z(angles[k]))
    frames.append(frames[-1].moved(chain.flange))
    return frames


def body_poses(chain: Chain, angles: Floats) -> tuple[Floats, Floats]:
    """Return where the undeformed bodies are.

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

    Column k is (z_k × (p − o_k), z_k), zero for joints outboard of the body (Wang, Zhang and Fuhlbrigge 2009, eq. 3).

    Parameters
    ----------
    chain : J joints.
    angles : (n, J) model angles, rad.
    attachment : the body and the frame whose origin is the point.

    Returns
    -------
    (n, 6, J) m/rad over rad/rad; a view whose memory has the state axis last.
    """
    n, n_joints = angles.shape
    result = np.zeros((6, n_joints, n))
    moving = min(attachment.body, n_joints)
    for start in range(0, n, BLOCK):
        block = slice(start, min(start + BLOCK, n))
        frames = stacked_bodies(chain, np.ascontiguousarray(angles[block].T))
        point = frames[attachment.body].point(attachment.transform[:3, 3])
        for k in range(moving):
            axis = frames[k + 1].rotation[:, 2]
            arm = point - frames[k + 1].position
            result[0, k, block] = axis[1] * arm[2] - axis[2] * arm[1]
            result[1, k, block] = axis[2] * arm[0] - axis[0] * arm[2]
            result[2, k, block] = axis[0] * arm[1] - axis[1] * arm[0]
            result[3:, k, block] = axis
    return np.moveaxis(result, -1, 0)
