"""The torques of a rigid chain in motion, linear in what its links weigh and how they are spread.

Newton's and Euler's equations, link by link: the wrench that moves link k is linear in ten numbers of it (mass, first
moments, inertia about its frame's origin), and so are the torques of all joints (Khalil & Dombre 2002, section 9.4).
A fit of these numbers takes weight and inertia out of a measured torque without knowing any mass.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain

PER_LINK = 10
"""mass; mass × centre (3); inertia about the origin xx, xy, xz, yy, yz, zz; all in the link's joint frame."""


def drive_matrix(chain: Chain) -> Floats:
    """Return (J, J): velocity of the model joints (row) per velocity of each drive (column).

    A drive counts in the sense of its logged angle, so that logged torques and velocities keep their signs. Its
    transpose takes torques about the model joints to the drives. Where the file states ``coupling = "mechanical"`` the
    drives sit on the logged axes and one of them turns several joints.
    """
    combined = np.count_nonzero(chain.coupling, axis=1) > 1
    signs = np.diag(np.sign(np.where(np.diagonal(chain.coupling) == 0.0, 1.0, np.diagonal(chain.coupling))))
    return np.where((combined & ~chain.mechanical)[:, None], signs, chain.coupling)


def inertial_regressor(chain: Chain, angles: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Return each joint's torque per unit of each inertial parameter of each link.

    Parameters
    ----------
    chain : J joints; its masses are not used.
    angles, velocity, acceleration : (n, J) of the model joints, rad, rad/s, rad/s².

    Returns
    -------
    (n, J, 10 J)
        Torque (N·m, what the drive gives) of joint j per unit of number i; numbers as in `PER_LINK`, link by link.
        Columns without effect on the torques are zero, others are collinear: only combinations can be identified.
    """
    n, count = angles.shape
    result = np.zeros((n, count, PER_LINK * count))
    turns: list[Floats] = []
    for k, (turn, *motion) in enumerate(_moving_links(chain, angles, velocity, acceleration)):
        turns.append(turn)
        wrench = _link_wrench(*motion)
        columns = slice(PER_LINK * k, PER_LINK * (k + 1))
        for j in range(k, -1, -1):
            result[:, j, columns] = wrench[:, 5]
            wrench = _carried(wrench, turns[j], chain.fixed[j, :3, 3])
    return result


def rigid_torque(chain: Chain, angles: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Return (n, J) torques of a chain of point masses as the robot file gives them, N·m; see `inertial_regressor`."""
    links = []
    for k, (turn, lift, spin, change) in enumerate(_moving_links(chain, angles, velocity, acceleration)):
        centre = chain.link_com[k]
        force = chain.link_mass[k] * (lift + np.cross(change, centre) + np.cross(spin, np.cross(spin, centre)))
        links.append((turn, np.concatenate([force, np.cross(centre, force)], axis=1)[:, :, None]))
    result, carried = np.zeros_like(angles), np.zeros((len(angles), 6, 1))
    for j in range(chain.n_joints - 1, -1, -1):
        turn, wrench = links[j]
        wrench = wrench + carried
        result[:, j] = wrench[:, 5, 0]
        carried = _carried(wrench, turn, chain.fixed[j, :3, 3])
    return result


def _moving_links(
    chain: Chain, angles: Floats, velocity: Floats, acceleration: Floats
) -> Iterator[tuple[Floats, Floats, Floats, Floats]]:
    """Yield each link's turn against the one inboard (n, 3, 3), and its motion as `_link_wrench` takes it.

    Arguments as those of `inertial_regressor`.
    """
    n, count = angles.shape
    spin, change = np.zeros((n, 3)), np.zeros((n, 3))
    lift = np.tile(-chain.gravity, (n, 1))  # weight as an acceleration of the base upwards
    for k in range(count):
        place = chain.fixed[k, :3, 3]
        turn = chain.fixed[k, :3, :3] @ _turns_about_z(angles[:, k])
        lift = lift + np.cross(change, place) + np.cross(spin, np.cross(spin, place))
        lift, spin, change = (np.einsum("nji,nj->ni", turn, rotation_rate) for rotation_rate in (lift, spin, change))
        axis = np.zeros((n, 3))
        axis[:, 2] = velocity[:, k]
        change = change + np.cross(spin, axis)
        change[:, 2] += acceleration[:, k]
        spin = spin + axis
        yield turn, lift, spin, change


def _carried(wrench: Floats, turn: Floats, place: Floats) -> Floats:
    """Return wrenches (n, 6, c) of a link in the axes and about the origin of the one inboard.

    Parameters
    ----------
    turn : (n, 3, 3) axes of the link in those of the one inboard. place : (3,) its origin there, m.
    """
    force = turn @ wrench[:, :3]
    return np.concatenate([force, turn @ wrench[:, 3:] + _skew(place) @ force], axis=1)


def _turns_about_z(angle: Floats) -> Floats:
    turn = np.zeros((angle.size, 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
    turn[:, 1, 0] = np.sin(angle)
    turn[:, 0, 1] = -turn[:, 1, 0]
    turn[:, 2, 2] = 1.0
    return turn


def _skew(vector: Floats) -> Floats:
    """Return (…, 3, 3) with ``_skew(a) @ b = a × b``."""
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _inertia_matrix(vector: Floats) -> Floats:
    """Return (n, 3, 6) with ``_inertia_matrix(a) @ (xx, xy, xz, yy, yz, zz) = I a``."""
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    rows = [[x, y, z, zero, zero, zero], [zero, x, zero, y, z, zero], [zero, zero, x, zero, y, z]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _link_wrench(lift: Floats, spin: Floats, change: Floats) -> Floats:
    """Return (n, 6, 10): force and moment about the link's origin per unit of its numbers, link axes.

    Parameters
    ----------
    lift : (n, 3) acceleration of the origin less gravity.
    spin, change : (n, 3) angular velocity and acceleration.
    """
    wrench = np.zeros((lift.shape[0], 6, PER_LINK))
    turning = _skew(spin)
    wrench[:, :3, 0] = lift
    wrench[:, :3, 1:4] = _skew(change) + turning @ turning
    wrench[:, 3:, 1:4] = -_skew(lift)
    wrench[:, 3:, 4:] = _inertia_matrix(change) + turning @ _inertia_matrix(spin)
    return wrench
