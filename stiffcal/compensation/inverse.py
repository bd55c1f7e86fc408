"""Joint angles for poses, on the rigid chain: where a path is given in space, or a map asks for a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats
from stiffcal.compensation.targets import PoseGoal, pose_error
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians

# Far below what a controller can command; Newton's last step makes it.
_CLOSE = 1e-9
_STEPS = 60
# The largest step of a joint, rad, and the damping that shrinks with the error: Levenberg's way from afar.
_LARGEST_STEP = 0.35
_LARGEST_DAMPING = 0.05


def joints_for_poses(
    chain: Chain, target: Attachment, goal: PoseGoal, start: Floats, orientation: bool = True, steps: int = _STEPS
) -> tuple[Floats, Booleans]:
    """Find joint angles that put a frame in wanted poses, each from a start of its own.

    Parameters
    ----------
    chain : the robot; its joint limits hold.
    target : the frame.
    goal : n poses, base axes.
    start : (n, L) logged angles to start from, rad.
    orientation : False where only the position counts.
    steps : at most.

    Returns
    -------
    joints : (n, L) logged angles, rad.
    reached : (n,) True where the pose is reached within the joint limits.
    """
    low, high = chain.limits.T
    joints = np.clip(start, low, high)
    rows = 6 if orientation else 3
    active = np.arange(len(joints))
    error = np.full((len(joints), rows), np.inf)
    for _ in range(steps + 1):
        open_goal = PoseGoal(goal.position[active], goal.rotation[active])
        angles = chain.model_angles(joints[active])
        error[active] = pose_error(*attached_poses(chain, angles, target), open_goal)[:, :rows]
        active = active[np.abs(error[active]).max(axis=1) > _CLOSE]
        if not active.size:
            break
        jacobian = (jacobians(chain, chain.model_angles(joints[active]), target) @ chain.coupling)[:, :rows]
        size = np.minimum(np.linalg.norm(error[active], axis=1), 1.0)
        damping = (_LARGEST_DAMPING * size)[:, None, None] ** 2 * np.eye(rows)
        normal = jacobian @ np.swapaxes(jacobian, 1, 2) + damping + 1e-12 * np.eye(rows)
        step = -np.einsum("nij,ni->nj", jacobian, np.linalg.solve(normal, error[active][:, :, None])[:, :, 0])
        longest = np.abs(step).max(axis=1, keepdims=True)
        joints[active] += step * np.minimum(1.0, _LARGEST_STEP / np.maximum(longest, 1e-12))
        np.clip(joints, low, high, out=joints)
    return joints, np.asarray(np.abs(error).max(axis=1) < 1e3 * _CLOSE, dtype=np.bool_)


def joints_along_path(
    chain: Chain, target: Attachment, goal: PoseGoal, start: Floats | None, orientation: bool = True, seed: int = 0
) -> tuple[Floats, Booleans]:
    """Find joint angles along a path of poses, each from the one before, so that the arm does not flip over.

    Parameters
    ----------
    start : (L,) logged angles near the first pose, rad; None: the way from the middle of the joints' ranges.

    Returns
    -------
    As `joints_for_poses`; after a pose that cannot be reached the next one is tried from the last that was.
    """
    n, n_logged = len(goal.position), chain.coupling.shape[1]
    joints, reached = np.zeros((n, n_logged)), np.zeros(n, dtype=np.bool_)
    first = PoseGoal(goal.position[:1], goal.rotation[:1])
    if start is None:
        last = nearest_solution(chain, target, first, middle_of_ranges(chain), orientation, seed)[0][0]
    else:
        last = start
    for k in range(n):
        single_goal = PoseGoal(goal.position[k : k + 1], goal.rotation[k : k + 1])
        solution, good = joints_for_poses(chain, target, single_goal, last[None], orientation)
        joints[k], reached[k] = solution[0], good[0]
        if good[0]:
            last = solution[0]
    return joints, reached


def nearest_solution(
    chain: Chain, target: Attachment, goal: PoseGoal, home: Floats, orientation: bool = True, seed: int = 0
) -> tuple[Floats, Booleans]:
    """Find for each pose the joint angles nearest to ``home`` (L,) among those that several starts lead to.

    Starts are ``home`` and, of many joint angles drawn within the limits, those whose poses lie nearest.

    Returns
    -------
    As `joints_for_poses`.
    """
    rng = np.random.default_rng(seed)
    n = len(goal.position)
    samples = drawn_joints(chain, rng, _DRAWN)
    place, turn = attached_poses(chain, chain.model_angles(samples), target)
    joints, reached = np.repeat(home[None], n, axis=0), np.zeros(n, dtype=np.bool_)
    for begin in range(0, n, _AT_ONCE):
        rows = slice(begin, min(begin + _AT_ONCE, n))
        few = PoseGoal(goal.position[rows], goal.rotation[rows])
        starts = samples[_nearest_drawn(few, place, turn, orientation)]
        starts = np.concatenate([np.repeat(home[None, None], len(starts), axis=0), starts], axis=1)
        nearest = np.full(len(starts), np.inf)
        for number in range(starts.shape[1]):
            solutions, good = joints_for_poses(chain, target, few, starts[:, number], orientation)
            distance = np.where(good, np.linalg.norm(solutions - home, axis=1), np.inf)
            better = distance < nearest
            joints[rows][better], nearest[better] = solutions[better], distance[better]
            reached[rows] |= good
        if chain.coupling.shape[1] > (6 if orientation else 3):
            joints[rows] = _moved_toward_home(chain, target, few, (joints[rows], home), orientation)
    return joints, reached


def _moved_toward_home(
    chain: Chain, target: Attachment, goal: PoseGoal, joints_home: tuple[Floats, Floats], orientation: bool
) -> Floats:
    """Return (n, L) joint angles, of redundant robots moved as near to home as the poses allow.

    The joints move along q = q₀ + J⁺ (J (q − q₀) − e); where that ends outside the limits they stay as they were.
    """
    start, home = joints_home
    low, high = chain.limits.T
    rows = 6 if orientation else 3
    joints = start.copy()
    for _ in range(12):
        error = pose_error(*attached_poses(chain, chain.model_angles(joints), target), goal)[:, :rows]
        jacobian = (jacobians(chain, chain.model_angles(joints), target) @ chain.coupling)[:, :rows]
        aim = np.einsum("nij,nj->ni", jacobian, joints - home) - error
        normal = jacobian @ np.swapaxes(jacobian, 1, 2) + 1e-6 * np.eye(rows)
        proposed = home + np.einsum("nij,ni->nj", jacobian, np.linalg.solve(normal, aim[:, :, None])[:, :, 0])
        joints = np.clip(joints + np.clip(proposed - joints, -_LARGEST_STEP, _LARGEST_STEP), low, high)
    closer, good = joints_for_poses(chain, target, goal, joints, orientation)
    nearer = good & (np.linalg.norm(closer - home, axis=1) < np.linalg.norm(start - home, axis=1))
    return np.where(nearer[:, None], closer, start)


def _nearest_drawn(goal: PoseGoal, place: Floats, turn: Floats, orientation: bool) -> NDArray[np.int64]:
    """Return (n, _STARTS) numbers of the drawn poses nearest to each goal; a radian counts as so many metres."""
    away = np.sum((goal.position[:, None] - place[None]) ** 2, axis=2)
    if orientation:
        # 3 − trace is the squared chord between two orientations
        away += _METRES_PER_RAD**2 * (3.0 - np.einsum("nij,mij->nm", goal.rotation, turn))
    return np.argpartition(away, _STARTS, axis=1)[:, :_STARTS]


# Starts tried for a pose besides home, of how many that are drawn, and how many poses are looked for at once.
_STARTS, _DRAWN, _AT_ONCE = 5, 3000, 1000
_METRES_PER_RAD = 0.5


def drawn_joints(chain: Chain, rng: np.random.Generator, n: int) -> Floats:
    """Draw (n, L) logged angles within the limits, rad; within half a turn where none are given."""
    low = np.where(np.isfinite(chain.limits[:, 0]), chain.limits[:, 0], -np.pi)
    high = np.where(np.isfinite(chain.limits[:, 1]), chain.limits[:, 1], np.pi)
    return np.asarray(low + (high - low) * rng.random((n, len(low))))


def middle_of_ranges(chain: Chain) -> Floats:
    """Return (L,) the middle of each joint's range, rad; zero where it has no limits."""
    middle = chain.limits.mean(axis=1) if np.isfinite(chain.limits).all() else np.zeros(len(chain.limits))
    return np.asarray(middle)
