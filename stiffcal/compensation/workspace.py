"""Deflection and stiffness over the workspace: where the robot reaches, and what it does there under a load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.compensation.inverse import drawn_joints, nearest_solution
from stiffcal.compensation.prediction import cartesian_compliance, parameter_covariance
from stiffcal.compensation.targets import PoseGoal
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance

RIGID = 1e-20  # m/N: a millionth of an atom under a meganewton

OUT_OF_REACH, BEYOND_LIMITS, REACHED = 0, 1, 2
# What a box of drawn places is widened by on either side, of its size.
_MARGIN = 0.03


@dataclass(frozen=True)
class MapTask:
    """What is to be mapped."""

    points: Floats
    """(n, 3) m, base axes, where the target is to stand."""
    home: Floats
    """(L,) rad, logged angles that solutions are to be near to."""
    rotation: Floats | None
    """(3, 3) base_from_target kept everywhere; None: the orientation is free."""
    wrench: Floats
    """(6,) N, N·m, base axes, about the set-up's wrench point."""
    direction: Floats | None = None
    """(3,) unit vector along which stiffness is wanted; None: no stiffness."""


@dataclass(frozen=True)
class WorkspaceMap:
    """What was found at n points; NaN where the robot does not reach."""

    points: Floats
    """(n, 3) m."""
    status: Integers
    """(n,) 0 out of reach, 1 only beyond joint limits, 2 reached."""
    joints: Floats
    """(n, L) rad, logged angles."""
    deflection: Floats
    """(n, 6) m, rad, base axes."""
    std: Floats
    """(n, 2) standard uncertainty of the deflection's position and rotation parts, root of the traces, m and rad."""
    stiffness: Floats
    """(n,) N/m along the direction, all other directions free to give; NaN where not wanted."""
    margin: Floats
    """(n,) rad to the nearest joint limit; infinite without limits."""
    smallest_singular: Floats
    """(n,) of the Jacobian: how near a singular pose is."""

    @property
    def position_error(self) -> Floats:
        """(n,) m, length of the deflection."""
        return np.asarray(np.linalg.norm(self.deflection[:, :3], axis=1))

    @property
    def orientation_error(self) -> Floats:
        """(n,) rad, angle of the deflection."""
        return np.asarray(np.linalg.norm(self.deflection[:, 3:], axis=1))


def map_workspace(
    robot: CompliantRobot,
    setup: MeasurementSetup,
    task: MapTask,
    covariance: Mapping[str, Mapping[str, float]] | None = None,
) -> WorkspaceMap:
    """Compute what a robot with values does at points of its workspace.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    setup : where load and target are.
    task : points, load, and what is wanted.
    covariance : of the parameters, by full names; None: taken as exact.

    Raises
    ------
    NoBalanceError : the load is more than the springs hold.
    """
    chain = robot.chain
    status, joints = _reach(chain, setup.targets[0], task)
    n = len(task.points)
    reached = np.flatnonzero(status == REACHED)
    workspace = WorkspaceMap(
        points=task.points,
        status=status,
        joints=joints,
        deflection=np.full((n, 6), np.nan),
        std=np.full((n, 2), np.nan),
        stiffness=np.full(n, np.nan),
        margin=np.full(n, np.nan),
        smallest_singular=np.full(n, np.nan),
    )
    if not reached.size:
        return workspace
    loads = replace(setup, wrench_axes=Attachment(0, np.eye(4)), moments_measured=True)
    angles = chain.model_angles(joints[reached])
    wrench = np.repeat(task.wrench[None], len(reached), axis=0)
    balance = solve_balance(robot, angles, wrench, loads)
    workspace.deflection[reached] = balance.displacement[:, 0]
    spread = parameter_covariance(robot, angles, wrench, loads, None, covariance or {})
    workspace.std[reached, 0] = np.sqrt(np.einsum("nii->n", spread[:, :3, :3]))
    workspace.std[reached, 1] = np.sqrt(np.einsum("nii->n", spread[:, 3:, 3:]))
    if task.direction is not None:
        compliance = cartesian_compliance(robot, angles, wrench, loads, balance)[:, :3, :3]
        gives = np.einsum("i,nij,j->n", task.direction, compliance, task.direction)
        # where nothing gives in that direction there is no stiffness to state
        workspace.stiffness[reached] = np.divide(
            1.0, gives, out=np.full_like(gives, np.nan), where=np.abs(gives) > RIGID
        )
    workspace.margin[reached] = np.minimum(
        joints[reached] - chain.limits[:, 0], chain.limits[:, 1] - joints[reached]
    ).min(axis=1)
    jacobian = jacobians(chain, angles, setup.targets[0])
    workspace.smallest_singular[reached] = np.linalg.svd(jacobian, compute_uv=False)[:, -1]
    return workspace


def _reach(chain: Chain, target: Attachment, task: MapTask) -> tuple[Integers, Floats]:
    """Return (n,) whether each point is reached, and (n, L) the joint angles there."""
    n = len(task.points)
    orientation = np.eye(3) if task.rotation is None else task.rotation
    goal = PoseGoal(task.points, np.repeat(orientation[None], n, axis=0))
    with_rotation = task.rotation is not None
    within_reach = np.flatnonzero(
        np.linalg.norm(task.points - chain.fixed[0, :3, 3], axis=1) <= longest_reach(chain, target)
    )
    status, joints = np.zeros(n, dtype=np.int64), np.full((n, len(task.home)), np.nan)
    if not within_reach.size:
        return status, joints
    solutions, reached = nearest_solution(chain, target, _some(goal, within_reach), task.home, with_rotation)
    joints[within_reach[reached]], status[within_reach[reached]] = solutions[reached], REACHED
    unreached = within_reach[~reached]
    if unreached.size and np.isfinite(chain.limits).any():
        # Is it the joint limits that keep the robot from there? The same chain without limits decides.
        free = replace(chain, limits=np.tile([-np.inf, np.inf], (len(chain.limits), 1)))
        _, reached = nearest_solution(free, target, _some(goal, unreached), task.home, with_rotation)
        status[unreached[reached]] = BEYOND_LIMITS
    return status, joints


def _some(goal: PoseGoal, which: Integers) -> PoseGoal:
    return PoseGoal(goal.position[which], goal.rotation[which])


def longest_reach(chain: Chain, target: Attachment) -> float:
    """Return a length, m, that the target cannot be away from the first joint's origin."""
    last_frame = chain.flange @ target.transform if target.body == chain.n_joints + 1 else target.transform
    steps = [*chain.fixed[1 : min(target.body, chain.n_joints)], last_frame]
    return float(sum(np.linalg.norm(step[:3, 3]) for step in steps))


def reached_box(chain: Chain, target: Attachment, seed: int = 0) -> Floats:
    """Return (3, 2) m, base axes: the box in which the target stands for joint angles drawn within the limits.

    A little wider: angles that are drawn hardly meet the outermost reach.
    """
    samples = drawn_joints(chain, np.random.default_rng(seed), 4000)
    place, _ = attached_poses(chain, chain.model_angles(samples), target)
    box = np.stack([place.min(axis=0), place.max(axis=0)], axis=1)
    return np.asarray(box + _MARGIN * np.ptp(box, axis=1)[:, None] * np.array([-1.0, 1.0]))
