"""How much of displacements joint springs explain, and the work of the load: what tables of loads are judged by.

A load that is read wrongly makes every later number wrong without looking wrong. A single mistake leaves the springs as
many numbers as before: what they explain with it taken back is compared by an F test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.estimation.bounded_least_squares import least_squares_within
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.mechanics.rotations import vector_from_rotation as rotation_vector
from stiffcal.reduction.loads.motion import less_means_of_runs, motion_of

# A load that follows the declared axes leaves less than half of the deflection to other effects.
FOLLOWS, FOLLOWS_NOT = 0.8, 0.5
# Of few poses any order of columns explains much.
LEAST_POSES = 3
# Angles of one pose as logs round them: a hundredth of a degree moves a tool by less than it deflects.
SAME_ANGLES_RAD = np.radians(0.01)
# The size of the test of another way to read a table, all that are tried counted.
BY_CHANCE = 1e-4
# Of the sum of squares: a millionth of the displacement, below what any instrument reads and above rounding.
NOTHING_LEFT = 1e-12
# Of the largest force: less is the weight of a tool, or a load that was not taken off, and has no direction.
LEAST_SHARE_OF_LOAD = 0.1


@dataclass(frozen=True)
class WorkSign:
    """Work of the load on the robot, per run, J; share of the deflection that positive joint springs explain."""

    work: Floats
    explained: float


def work_of_load(states: LoadStates, chain: Chain) -> WorkSign:
    """Return Σ wrench · displacement about the load's point in each run (differences to the run's reference), J."""
    return WorkSign(work_of_runs(states, chain), explained_by_joints(states, chain))


def work_of_runs(states: LoadStates, chain: Chain) -> Floats:
    """Return (R,) the same work alone, J."""
    force, moment, translation, rotation = _loads_and_motions(states, chain)
    work = np.sum(force * translation, axis=1) + np.sum(moment * rotation, axis=1)
    return np.asarray(np.bincount(states.run, weights=work, minlength=len(states.runs)), dtype=np.float64)


def _loads_and_motions(states: LoadStates, chain: Chain) -> tuple[Floats, Floats, Floats, Floats]:
    """Return force, moment, displacement of the load's point and turn, base axes, relative to the reference: (n, 3)."""
    angles = chain.model_angles(states.joints)
    _, axes = attached_poses(chain, angles, states.setup.wrench_axes)
    point, _ = attached_poses(chain, angles, states.setup.wrench_point)
    target, _ = attached_poses(chain, angles, states.setup.targets[0])
    force = np.einsum("nij,nj->ni", axes, states.wrench[:, :3])
    moment = np.einsum("nij,nj->ni", axes, states.wrench[:, 3:])
    if states.deflection_given:
        translation, rotation = states.deflection[:, 0, :3].copy(), np.nan_to_num(states.deflection[:, 0, 3:])
    else:
        references = _references(states)
        force, moment = force - force[references], moment - moment[references]
        turn = states.rotation[:, 0] @ states.rotation[references, 0].swapaxes(1, 2)
        measured = np.isfinite(turn).all(axis=(1, 2))
        measured &= ~np.isin(states.run, states.run[~measured])  # of a run all states or none
        rotation = np.zeros_like(force)
        rotation[measured] = rotation_vector(turn[measured])
        translation = motion_of(states, chain).since(references)
    return force, moment, np.nan_to_num(translation + np.cross(rotation, point - target)), rotation


def _references(states: LoadStates) -> Integers:
    """Return (n,) of each state its run's first reference, or first state where it has none."""
    references = np.zeros(len(states), dtype=np.int64)
    first = np.argsort(~states.reference, kind="stable")  # references before others, each in order
    _, place, number = np.unique(states.run[first], return_index=True, return_inverse=True)
    references[first] = first[place][number.ravel()]
    return references


def explained_by_joints(states: LoadStates, chain: Chain, flip: Floats | None = None, sign: float = 1.0) -> float:
    """Return the share of displacement that non-negative joint compliances explain, sensor axes turned by `flip`."""
    left, measured = left_by_joints(states, chain, flip, sign)
    total = float(measured @ measured)
    return 1.0 - float(left @ left) / total if total > 0.0 else 1.0


def left_by_joints(
    states: LoadStates, chain: Chain, flip: Floats | None = None, sign: float = 1.0
) -> tuple[Floats, Floats]:
    """Return (k,) what non-negative joint compliances leave of the k measured components, and these themselves, m.

    Of places what counts is the distance from their mean in each run.
    """
    design, target, _ = _springs(states, chain, flip, sign)
    return target - _predicted(design, target), target


def _springs(
    states: LoadStates, chain: Chain, flip: Floats | None = None, sign: float = 1.0
) -> tuple[Floats, Floats, Integers]:
    """Return (k, J) displacement per compliance, (k,) as measured, m, and (k,) the number of the state."""
    angles = chain.model_angles(states.joints)
    _, axes = attached_poses(chain, angles, states.setup.wrench_axes)
    joint_axes = sign * (axes if flip is None else axes @ flip)
    wrench = np.concatenate(
        [
            np.einsum("nij,nj->ni", joint_axes, states.wrench[:, :3]),
            np.einsum("nij,nj->ni", joint_axes, states.wrench[:, 3:]),
        ],
        axis=1,
    )
    # springs sit at the drives
    drives = jacobians(chain, angles, states.setup.wrench_point) @ chain.drive_axes
    torque = np.einsum("nij,ni->nj", drives, wrench)
    motion = motion_of(states, chain)
    columns = motion.columns(states, chain) @ chain.drive_axes * torque[:, None, :]
    measured = motion.measured
    if not states.deflection_given:
        columns, measured = (less_means_of_runs(values, states.run) for values in (columns, measured))
    rows = np.isfinite(measured).ravel()
    number = np.repeat(np.arange(len(states)), measured.shape[1])[rows]
    return columns.reshape(-1, columns.shape[2])[rows], measured.ravel()[rows], number


def _predicted(design: Floats, target: Floats) -> Floats:
    """Return (k,) what non-negative compliances make of a design (k, J)."""
    scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    gram, right = np.linalg.qr(design / scale)
    zero = np.zeros(right.shape[1])
    value, _ = least_squares_within(right, gram.T @ target, zero, zero + np.inf)
    return np.asarray(gram @ (right @ value))


def chance_of_loads(states: LoadStates, mended: LoadStates, chain: Chain) -> tuple[float, float]:
    """Return two probabilities: by chance, springs need what they predict under other loads, and the reverse.

    Two models of one displacement, neither of which includes the other: what one predicts is a column more in the
    other, and its coefficient is zero where that one is right (J test: Davidson and MacKinnon, Econometrica 49, 1981).
    Its variance is that of clusters (Liang and Zeger, Biometrika 73, 1986): what the springs lack is shared by the
    states of a pose.

    Parameters
    ----------
    states : as read. mended : the same states under other loads.
    """
    (design, target, number), (other, _, _) = _springs(states, chain), _springs(mended, chain)
    poses = np.unique(np.round(states.joints / SAME_ANGLES_RAD), axis=0, return_inverse=True)[1].ravel()[number]
    return (
        _chance_of_column(design, target, _predicted(other, target), poses),
        _chance_of_column(other, target, _predicted(design, target), poses),
    )


def _chance_of_column(design: Floats, target: Floats, column: Floats, poses: Integers) -> float:
    """Return the probability by which a column more (k,) has so large a coefficient by chance, both signs counted."""
    from scipy.special import stdtr

    axes, size, _ = np.linalg.svd(design / np.maximum(np.linalg.norm(design, axis=0), 1e-300), full_matrices=False)
    axes = axes[:, size > NOTHING_LEFT * size[0]]
    own = column - axes @ (axes.T @ column)
    count = len(np.unique(poses))
    if count < 2 or own @ own <= NOTHING_LEFT * (column @ column):
        return 1.0
    slope = float(own @ target) / float(own @ own)
    left = target - axes @ (axes.T @ target) - slope * own
    spread = np.bincount(poses, weights=own * left) / float(own @ own)
    deviation = np.sqrt(count / (count - 1) * float(spread @ spread))
    return float(2.0 * stdtr(count - 1, -abs(slope) / max(deviation, 1e-300)))


def chance_of(explained: float, share: float, states: LoadStates, chain: Chain) -> float:
    """Return the probability by which springs explain so much more with another reading of a table by chance."""
    from scipy.special import fdtrc

    free = 3 * count_poses(states) - chain.n_joints
    if free < 2:
        return 1.0
    return float(fdtrc(free, free - 1, max(1.0 - explained, NOTHING_LEFT) / max(1.0 - share, NOTHING_LEFT)))


def is_better(explained: float, share: float, states: LoadStates, chain: Chain, tried: int = 1) -> bool:
    """Return whether springs explain by so much more that it is no chance among the readings that were tried."""
    return share > max(FOLLOWS, explained) and chance_of(explained, share, states, chain) * tried <= BY_CHANCE


def count_poses(states: LoadStates) -> int:
    """Return the number of different poses."""
    return len(np.unique(np.round(states.joints / SAME_ANGLES_RAD), axis=0))


def count_distinct(states: LoadStates) -> int:
    """Return the number of different states: one row written ten times is one reading."""
    measured = [values.reshape(len(states), -1) for values in (states.position, states.deflection)]
    rows = np.nan_to_num(np.concatenate([states.joints, states.wrench, *measured], axis=1))
    return len(np.unique(rows, axis=0))


def count_loads(states: LoadStates) -> int:
    """Return the number of directions of the load on the robot, poses that are alike taken as one."""
    size = np.linalg.norm(states.wrench[:, :3], axis=1)
    loaded = size > LEAST_SHARE_OF_LOAD * size.max()
    direction = states.wrench[loaded, :3] / size[loaded, None]
    return len(np.unique(np.round(np.concatenate([states.joints[loaded], direction], axis=1), 1), axis=0))


def joint_springs(states: LoadStates, chain: Chain) -> tuple[Floats, Floats, Floats]:
    """Return readings (n, q), torque per unit of reading (n, J, q) and displacement per unit of torque (n, 3, J)."""
    angles = chain.model_angles(states.joints)
    _, axes = attached_poses(chain, angles, states.setup.wrench_axes)
    levers = jacobians(chain, angles, states.setup.wrench_point)
    drives = chain.drive_axes
    torque = np.concatenate(
        [np.einsum("njk,nka->nja", levers[:, columns].swapaxes(1, 2), axes) for columns in (slice(0, 3), slice(3, 6))],
        axis=2,
    )
    n_components = 6 if np.any(states.wrench[:, 3:]) else 3
    motion = motion_of(states, chain, all_targets=True)
    return (
        states.wrench[:, :n_components],
        (drives.T @ torque)[:, :, :n_components],
        motion.columns(states, chain) @ drives,
    )
