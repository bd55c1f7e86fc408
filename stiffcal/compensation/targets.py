"""Joint targets that bring the loaded robot where it is wanted.

The controller is given q′ instead of q, such that the robot, balanced under its weight and the load, stands in the
wanted pose. Why solved and not one Newton step: a correction moves the levers of load and weight, which one step leaves
out; with the chain's own Jacobian in place of the balanced robot's every further step gains two digits or more.

Least motion: of all joint targets that reach the pose, the nearest to the commanded ones is taken; with seven joints
that is one of many (q′ = q + J⁺ (e + J (q′ − q)), repeated), with six the only one near by.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.compensation.prediction import one_run, parameter_covariance
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.dual_quaternions import displacement_of_duals, dual_from_pose
from stiffcal.mechanics.kinematics import jacobians
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import Balance, solve_balance
from stiffcal.model.effect import StateOrder
from stiffcal.uncertainty import NORMAL_95

# A micrometre and a microradian are asked for; a thousandth of that is what the steps stop at.
REACHED_M, REACHED_RAD = 1e-6, 1e-6
_STOP = 1e-9
_MAX_STEPS = 30
# A joint turn smaller than this share of the largest makes so little way that a correction would be sought far off.
_SINGULAR = 1e-3
# Compensation corrects millimetres; a joint that would have to go farther stands near a singular pose.
LARGEST_CORRECTION = np.radians(5.0)


@dataclass(frozen=True)
class PoseGoal:
    """Wanted places of the first target, base axes."""

    position: Floats
    """(n, 3) m."""
    rotation: Floats
    """(n, 3, 3) base_from_target."""


@dataclass(frozen=True)
class CorrectionOptions:
    """What is to be reached, and how."""

    goal: PoseGoal | None = None
    """The wanted poses; None: where the robot would stand at the commanded angles without the load."""
    orientation: bool = True
    """False where only the position counts."""
    in_order: bool = False
    """The states follow each other in one run (laws with a memory), loads and all."""
    time: Floats | None = None
    """(n,) s of the states, for laws that go by time; None where not known."""
    largest_correction: float = LARGEST_CORRECTION
    """rad, how far a joint may go from its commanded angle."""


@dataclass(frozen=True)
class Corrected:
    """Corrected joint targets of n states, base axes throughout."""

    joints: Floats
    """(n, L) logged angles to command, rad."""
    before: Floats
    """(n, 6) pose error without correction (reached minus wanted), m, then rotation vector, rad."""
    after: Floats
    """(n, 6) the same with the correction, by the model itself: below a micrometre where ``reached``."""
    covariance: Floats
    """(n, 6, 6) of the error that the model's uncertainty leaves."""
    deflection: Floats
    """(n, 6) what the load alone does at the commanded angles."""
    reached: Booleans
    """(n,) True where the whole wish is met."""
    position_reached: Booleans
    """(n,) True where at least the position is: orientation gives way where both cannot be had."""
    held: tuple[tuple[str, ...], ...]
    """n times the names of the joints that a limit stopped."""
    singular: Booleans
    """(n,) True where a correction would have gone farther than a joint may."""

    @property
    def std(self) -> Floats:
        """(n, 6) m, rad: standard uncertainty of the error, component by component."""
        return np.asarray(np.sqrt(np.einsum("nii->ni", self.covariance)))

    @property
    def residual_95(self) -> Floats:
        """(n,) m, what the length of the position's error keeps under with 95 %, by the model's own uncertainty."""
        # The length of a normal vector keeps below 1.96 √trace with 95 % or more: exactly where one direction rules.
        spread = np.sqrt(np.einsum("nii->n", self.covariance[:, :3, :3]))
        return np.asarray(NORMAL_95 * spread + np.linalg.norm(self.after[:, :3], axis=1))


def correct_joints(
    robot: CompliantRobot,
    joints: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    options: CorrectionOptions | None = None,
    covariance: Mapping[str, Mapping[str, float]] | None = None,
) -> Corrected:
    """Solve for the joint targets that put the loaded robot's first target where it is wanted.

    Parameters
    ----------
    robot : chain and effects, every parameter with a value.
    joints : (n, L) commanded logged angles, rad.
    wrench : (n, 6) N and N·m on the robot, in the set-up's wrench axes about its wrench point.
    setup : where load and target are.
    options : what is to be reached; None: the pose without the load.
    covariance : of the parameters, by full names; None: taken as exact.

    Raises
    ------
    NoBalanceError : a load is more than the springs hold.

    Notes
    -----
    Within the chain's limits: a joint that would go beyond is kept at its limit and the others make up for it where
    they can (seven joints can); what remains stands in ``after``.
    """
    options = options or CorrectionOptions()
    problem = _CorrectionProblem(robot, joints, wrench, setup, options)
    solution = problem.solve()
    angles = robot.chain.model_angles(solution.joints)
    weight = options.goal is not None
    return replace(
        solution,
        covariance=parameter_covariance(robot, angles, wrench, setup, problem.order, covariance or {}, weight),
    )


def errors_of(
    robot: CompliantRobot,
    commanded: Floats,
    corrected: Floats,
    wrench: Floats,
    setup: MeasurementSetup,
    options: CorrectionOptions,
) -> Floats:
    """Return (n, 6) the pose errors of a robot that is given corrected joint targets, by any model.

    Parameters
    ----------
    robot : that moves; it may be another than the one that the targets were computed for.
    commanded : (n, L) logged angles of the wanted poses, rad.
    corrected : (n, L) joint targets that the controller is given, rad.
    wrench, setup, options : as in `correct_joints`.
    """
    problem = _CorrectionProblem(robot, commanded, wrench, setup, options)
    return problem.error_at(corrected, np.arange(len(corrected)))


def pose_error(position: Floats, rotation: Floats, goal: PoseGoal) -> Floats:
    """Return (n, 6) reached minus wanted: positions, m, and the rotation vector of R R_wantedᵀ, rad; base axes.

    Taken from the poses as unit dual quaternions, Δq̂ = p̂ ∘ q̂⁻¹ (003, eq. 36), which has no singular orientation.
    """
    return displacement_of_duals(dual_from_pose(position, rotation), dual_from_pose(goal.position, goal.rotation))


class _CorrectionProblem:
    """The equations of n states and the way to their solution; arrays of all states are filled in as they are found."""

    def __init__(
        self, robot: CompliantRobot, joints: Floats, wrench: Floats, setup: MeasurementSetup, options: CorrectionOptions
    ) -> None:
        self.robot, self.commanded, self.wrench, self.setup, self.options = robot, joints, wrench, setup, options
        self.chain = robot.chain
        self.order: StateOrder | None = one_run(robot, len(joints), options.time) if options.in_order else None
        start = self._balance(joints)
        self.deflection = start.displacement[:, 0]
        self.goal = options.goal or PoseGoal(start.unloaded_position[:, 0], start.unloaded_rotation[:, 0])
        self.before = self._error(start)
        self.joints, self.error = joints.copy(), self.before.copy()
        self.at_limit = np.zeros(joints.shape, dtype=np.bool_)
        self.too_far = np.zeros(len(joints), dtype=np.bool_)

    def _balance(self, joints: Floats, rows: Integers | None = None) -> Balance:
        """Find the balances; of some states alone only where each stands alone."""
        wrench = self.wrench if rows is None else self.wrench[rows]
        return solve_balance(self.robot, self.chain.model_angles(joints), wrench, self.setup, self.order)

    def _error(self, balance: Balance, rows: Integers | None = None) -> Floats:
        goal = self.goal if rows is None else PoseGoal(self.goal.position[rows], self.goal.rotation[rows])
        if self.robot.deformed:
            return pose_error(balance.target_position[:, 0], balance.target_rotation[:, 0], goal)
        # The linear form counts the deflection from the rigid chain, and lets the sag out with it.
        at = pose_error(balance.unloaded_position[:, 0], balance.unloaded_rotation[:, 0], goal)
        return at + balance.displacement[:, 0]

    def error_at(self, joints: Floats, rows: Integers) -> Floats:
        """Return (m, 6) the pose errors of some states at their joint targets (m, L) out of all (n, L)."""
        if self.order is None:
            return self._error(self._balance(joints[rows], rows), rows)
        return self._error(self._balance(joints))[rows]

    def solve(self) -> Corrected:
        """Find the joint targets; where a pose cannot be had (singular, a limit), at least its position."""
        n = len(self.commanded)
        with_rotation = np.full(n, self.options.orientation)
        self._go(np.arange(n), with_rotation)
        redo = np.flatnonzero(with_rotation & ~self._reached(with_rotation))
        if redo.size:
            with_rotation[redo] = False
            stopped = self.at_limit.copy()
            self.joints[redo], self.at_limit[redo] = self.commanded[redo], False
            self._go(redo, with_rotation)
            self.at_limit |= stopped  # what kept the whole pose from being reached is worth knowing too
        names = self.chain.joint_names
        return Corrected(
            joints=self.joints,
            before=self.before,
            after=self.error,
            covariance=np.zeros((n, 6, 6)),
            deflection=self.deflection,
            reached=self._reached(np.full(n, self.options.orientation)),
            position_reached=self._reached(np.zeros(n, dtype=np.bool_)),
            held=tuple(tuple(names[k] for k in np.flatnonzero(row)) for row in self.at_limit),
            singular=self.too_far,
        )

    def _reached(self, with_rotation: Booleans) -> Booleans:
        place = np.linalg.norm(self.error[:, :3], axis=1) < REACHED_M
        turn = np.linalg.norm(self.error[:, 3:], axis=1) < REACHED_RAD
        return np.asarray(place & (turn | ~with_rotation), dtype=np.bool_)

    def _go(self, rows: Integers, with_rotation: Booleans) -> None:
        """Take some states to their joint targets step by step, each until it stands still.

        Parameters
        ----------
        rows : numbers of the states.
        with_rotation : (n,) True where the orientation is to be reached too.
        """
        self.error[rows] = self.error_at(self.joints, rows)
        for _ in range(_MAX_STEPS):
            before = self.joints[rows]
            wanted = self._step(rows, with_rotation)
            newly = self._beyond(wanted) & ~self.at_limit[rows]
            if newly.any():
                # A joint stops at its limit: the others make up for it from the next step on.
                self.at_limit[rows] |= newly
            wanted = np.clip(wanted, *self.chain.limits.T)
            too_far = (np.abs(wanted - self.commanded[rows]) > self.options.largest_correction).any(axis=1)
            self.too_far[rows] |= too_far
            wanted[too_far] = before[too_far]
            self.joints[rows] = wanted
            self.error[rows] = self.error_at(self.joints, rows)
            moving = (np.abs(wanted - before).max(axis=1) > _STOP) | newly.any(axis=1)
            rows = rows[moving & ~too_far]
            if not rows.size:
                break

    def _step(self, rows: Integers, with_rotation: Booleans) -> Floats:
        """Return (m, L) the next joint targets: least motion from the commanded angles, held joints at their limit."""
        joints, commanded, at_limit = self.joints[rows], self.commanded[rows], self.at_limit[rows]
        counted = np.ones((len(rows), 6))
        counted[~with_rotation[rows], 3:] = 0.0
        jacobian = jacobians(self.chain, self.chain.model_angles(joints), self.setup.targets[0]) @ self.chain.coupling
        correction = joints - commanded
        at_limits = np.where(at_limit, correction, 0.0)
        # e(q′) ≈ e + J (q′ − q): brought to zero by the smallest correction of the free joints.
        aim = counted * (np.einsum("nij,nj->ni", jacobian, correction - at_limits) - self.error[rows])
        inverse = np.linalg.pinv(counted[:, :, None] * jacobian * ~at_limit[:, None, :], rcond=_SINGULAR)
        return np.asarray(commanded + at_limits + np.einsum("nji,ni->nj", inverse, aim))

    def _beyond(self, wanted: Floats) -> Booleans:
        low, high = self.chain.limits.T
        return np.asarray((wanted < low) | (wanted > high), dtype=np.bool_)
