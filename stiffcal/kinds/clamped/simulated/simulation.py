"""Clamped runs: one motor driven to and fro while the flange is held, and the wrench with which the fixture answers.

The unknown is the wrench. It is found where the balanced robot's flange, motors turned, stands where the fixture holds
it: X(q(t), W) = X(q₀, 0) − C_fixture W (physics, section 1). A first answer comes from the drives' laws in first order
(monotonic, so that Newton's method with halved steps arrives), the exact one from the robot's own finite balance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.clamped.simulated.observation import compliance_of_fixture, drift_of_readings
from stiffcal.kinds.clamped.simulated.simulation_settings import Clamping
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.kinematics import jacobians
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import Balance, NoBalanceError, RobotAtJoints, solve_balance
from stiffcal.model.balance.rest import law_terms, node_displacements
from stiffcal.model.effect import RZ, NodeLoads, StateOrder, joint_node, tool_node
from stiffcal.simulation.kinds import RunSetup, RunSimulation
from stiffcal.simulation.played.drive_friction import friction_torque
from stiffcal.simulation.played.motion import MotionProgram, motion_program
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight, TrueRun
from stiffcal.simulation.settings import FILE_NAME

_BASE = Attachment(0, np.eye(4))
# A nanometre and a nanoradian: below a thousandth of a newton metre on the stiffest joint.
SETTLED = 2e-9
MOST_STEPS = 12
_SLOPE_STEP = 1e-6  # rad
# A step with first-order slopes that leaves less than this share is followed by another; true slopes cost as much as
# one step for each drive.
_APPROACHES = 0.3
_TABLE = 6001
_CROWDING = 17.0
# A drive without any give counts with this one, rad/(N·m): a hundred-thousandth of a stiff one's.
_RIGID = 1e-12


def sweep_program(clamping: Clamping, joints: Floats, moved_joint: int) -> MotionProgram:
    """Return the motion of one clamped run: rest, to and fro, rest.

    Parameters
    ----------
    clamping : amplitude, times.
    joints : (L,) rad, where the robot was clamped.
    moved_joint : from 1.

    Examples
    --------
    >>> program = sweep_program(Clamping(amplitude_deg=0.1, cycles=2), np.zeros(6), 3)
    >>> round(float(np.rad2deg(np.ptp(program.joints[:, 2]))), 6), bool(np.ptp(program.joints[:, 1]) == 0.0)
    (0.2, True)
    """
    quarter = 0.25 * clamping.period_s
    times, places = [0.0, clamping.rest_s], [0.0, 0.0]
    middle, amplitude = np.deg2rad(clamping.middle_deg), np.deg2rad(clamping.amplitude_deg)
    turns = [middle + amplitude * (1 if k % 2 == 0 else -1) for k in range(2 * clamping.cycles + 1)]
    if not clamping.both_ways:
        turns = turns[:1]
    for number, turn in enumerate(turns):
        times.append(times[-1] + (quarter if number == 0 else 2.0 * quarter))
        places.append(turn)
    if clamping.both_ways:
        times.append(times[-1] + quarter)
        places.append(0.0)
    times.append(times[-1] + clamping.rest_s)
    places.append(places[-1])
    pieces = [np.array([0.0])]
    for k in range(1, len(times)):
        # half a sweep takes the same places as a whole one, so that each is solved once
        share = abs(places[k] - places[k - 1]) / (2.0 * amplitude)
        count = max(2, round(clamping.points * share))
        pieces.append(np.linspace(times[k - 1], times[k], count + 1)[1:])
    node = np.concatenate(pieces)
    path = np.repeat(joints[None], node.size, axis=0)
    path[:, moved_joint - 1] += np.interp(node, times, places)
    return motion_program(node, path, moved_joint)


def simulate_clamped(
    robot: CompliantRobot, planned: PlannedRun, frames: Mapping[str, Attachment], tool: ToolWeight, fixture: Floats
) -> TrueRun:
    """Play one clamped run.

    Parameters
    ----------
    robot : chain and effects with values.
    planned : its program is a motion; its load point is where the fixture holds.
    frames : the frames that instruments look at.
    tool : what is mounted on the flange.
    fixture : (6, 6) compliance of the fixture, m/N and rad/(N·m), base axes; what the model adds to it not included.

    Raises
    ------
    InputError
        No wrench is found that holds the flange in place.
    """
    program = planned.program
    assert isinstance(program, MotionProgram)
    # Without a memory the same motor angles meet the same wrench: each place is solved once.
    warms = bool(np.any(np.ptp(planned.kelvin(program.node)) > 0.0))
    distinct, index_of_node = _distinct(program.joints[:, program.moved_joint - 1], robot.has_memory or warms)
    whole = fixture + compliance_of_fixture(robot)
    nodes, kelvin = _nodes_of(program, distinct), planned.kelvin(program.node[distinct])
    clamped = _ClampedRobot(robot, nodes, planned.load_point, tool, whole, int(index_of_node[0]), kelvin)
    wrench, balance = clamped.solve(planned.name)
    later = np.append(True, np.diff(program.node) > 0.0)  # without a rest before or after, two nodes share a moment
    moving = np.gradient(program.joints[later], program.node[later], axis=0)[np.cumsum(later) - 1]
    drives = robot.chain.drive_axes
    carried = -(balance.joint_torque @ drives)[index_of_node]
    time = program.node
    torque = carried + friction_torque(robot, program.joints, moving, carried, time, planned.warmer(time))
    read = program.joints + drift_of_readings(robot, time, planned.warmer(time) - planned.warmer(np.zeros(1)))
    solved_program = replace(program, joints=read, wrench_at_node=wrench[index_of_node], torque=torque)
    setup = replace(clamped.setup, targets=tuple(frames.values()), target_names=tuple(frames))
    model_angles = robot.chain.model_angles(program.joints[distinct])
    solved = solve_balance(robot, model_angles, wrench, setup, clamped.order)
    position, turn, unloaded = {}, {}, {}
    for body, name in enumerate(frames):
        places, rotations = solved.target_position[index_of_node, body], solved.target_rotation[index_of_node, body]
        start = np.eye(4)
        start[:3, :3], start[:3, 3] = rotations[0], places[0]
        position[name], unloaded[name] = places, start
        turn[name] = vector_from_rotation(rotations @ rotations[0].T)
    return TrueRun(replace(planned, program=solved_program), program.node, position, turn, unloaded)


def _distinct(place: Floats, keep_all: bool) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the nodes to solve, and the one of these that each node repeats; all of them where the path matters."""
    if keep_all:
        every = np.arange(place.size)
        return every, every
    _, distinct, index_of_node = np.unique(np.round(place, 11), return_index=True, return_inverse=True)
    return distinct, index_of_node


def _nodes_of(program: MotionProgram, some: NDArray[np.int64]) -> MotionProgram:
    """Return the motion at some nodes."""
    return replace(program, node=program.node[some], joints=program.joints[some])


@dataclass(frozen=True)
class _ClampedRobot:
    """A robot whose flange is held, over the nodes of one motion; ``start`` is the node in which it was clamped."""

    robot: CompliantRobot
    program: MotionProgram
    clamp: Attachment
    tool: ToolWeight
    fixture: Floats
    start: int
    kelvin: Floats  # (s,) the temperature, NaN where none is logged

    @property
    def setup(self) -> MeasurementSetup:
        return MeasurementSetup(
            wrench_axes=_BASE,
            wrench_point=self.clamp,
            targets=(self.clamp,),
            target_names=("clamp",),
            moments_measured=True,
            tool_mass=self.tool.mass,
            tool_com=self.tool.com,
        )

    @property
    def order(self) -> StateOrder:
        """The nodes in order, for laws with a memory."""
        s, n_joints = self.program.node.size, self.robot.chain.n_joints
        return StateOrder(
            run=np.zeros(s, dtype=np.int64),
            time=self.program.node,
            hold=np.zeros(s),
            motor=np.zeros((n_joints, s)),
            temperature=self.kelvin - self.kelvin[self.start],
            since_reference=self.program.node,
            kelvin=self.kelvin,
        )

    def solve(self, name: str) -> tuple[Floats, Balance]:
        """Return (s, 6) the fixture's wrench, base axes about the clamp, and the balance under it.

        Unknown are the drives' angles, not the wrench: torque over angle is flat in the play and steep on the flanks,
        and what is solved, δ + J⁺ C J⁺ᵀ τ(δ) + J⁺ (motion) = 0, is the identity and something positive.
        """
        chain, setup, order = self.robot.chain, self.setup, self.order
        model_angles = chain.model_angles(self.program.joints)
        jacobian = jacobians(chain, model_angles[self.start][None], self.clamp)[0] @ chain.drive_axes
        inverse = self._inverse(jacobian, name)
        drives = _Drives(self.robot, model_angles[self.start])
        none = np.zeros((len(model_angles), 6))
        standing = RobotAtJoints(self.robot, model_angles, setup, order, keep=True)
        rest = self._solve_equilibrium(standing, none, name)
        weight = rest.joint_torque @ chain.drive_axes
        position, rotation = rest.target_position[self.start, 0], rest.target_rotation[self.start, 0]
        coupling = inverse @ (self._other_compliance(model_angles[self.start], drives) + self.fixture) @ inverse.T
        sagged = drives.angle_of(weight)

        def left_of(load: Floats, balance: Balance) -> Floats:
            translation = balance.target_position[:, 0] - position
            turn = vector_from_rotation(balance.target_rotation[:, 0] @ rotation.T)
            return np.asarray((np.concatenate([translation, turn], axis=1) + load @ self.fixture.T) @ inverse.T)

        motion = left_of(none, rest)
        angle = _first_order(drives, motion, coupling, sagged, weight) + sagged
        geometric_torque = np.zeros_like(
            weight
        )  # what the drives carry more because the wrench acts on the deformed chain

        def at(angle: Floats) -> tuple[Floats, Balance, Floats]:
            wrench = (drives.torque_of(angle) - weight - geometric_torque) @ inverse
            balance = self._solve_equilibrium(standing, wrench, name)
            return wrench, balance, left_of(wrench, balance)

        last = np.inf
        for _ in range(MOST_STEPS):
            wrench, balance, residual = at(angle)
            left = float(np.abs(residual).max())
            if left < SETTLED:
                return wrench, balance
            carried = balance.joint_torque @ chain.drive_axes
            approaches, last = left < _APPROACHES * last, left
            if approaches:
                geometric_torque = carried - (wrench @ jacobian + weight)
                angle = drives.angle_of(carried)
                angle = angle - _newton(coupling, drives.stiffness(angle), residual)
                continue
            # A wrench softens drives that stand in their play, and turns them against each other: the slope as it is.
            slopes = np.empty((*angle.shape, angle.shape[1]))
            for k in range(angle.shape[1]):
                shifted = angle.copy()
                shifted[:, k] += _SLOPE_STEP
                slopes[:, :, k] = (at(shifted)[2] - residual) / _SLOPE_STEP
            angle = angle - np.linalg.solve(slopes, residual[:, :, None])[:, :, 0]
        raise InputError.at(
            FaultCode.NO_CONVERGENCE,
            FILE_NAME, f'runs "{name}"', "no wrench was found that keeps the flange in place while the motor moves",
            "lower clamped.amplitude_deg, or use more points",
        )  # fmt: skip

    def _inverse(self, jacobian: Floats, name: str) -> Floats:
        """Return (J, 6) the pseudo-inverse; raises where joints turn the flange alike and they stay undistinguished."""
        # lengths count by the lever, so that metres and radians weigh alike
        lever = max(float(np.sqrt(np.mean(np.sum(jacobian[:3] ** 2, axis=0)))), 1e-6)
        scale = np.array([1.0 / lever] * 3 + [1.0] * 3)
        scaled = scale[:, None] * jacobian
        if np.linalg.matrix_rank(scaled, tol=1e-4) < jacobian.shape[1]:
            raise InputError.at(
                FaultCode.SIMULATION_UNSUPPORTED,
                FILE_NAME, f'runs "{name}": joints_deg', "in this pose several joints move the clamped flange alike",
                "choose another pose: the share of each joint is not determined here",
            )  # fmt: skip
        return np.asarray(np.linalg.pinv(scaled) * scale)

    def _solve_equilibrium(self, standing: RobotAtJoints, wrench: Floats, name: str) -> Balance:
        """Return the finite balance under a wrench (s, 6); raise where there is none."""
        try:
            return standing.under(wrench)
        except NoBalanceError as error:
            raise error.of_load(FILE_NAME, f'runs "{name}"', "lower clamped.amplitude_deg") from None

    def _other_compliance(self, model_angles: Floats, drives: _Drives) -> Floats:
        """Return (6, 6) the compliance that is not the drives', by unit wrenches."""
        unit = np.concatenate([np.zeros((1, 6)), np.eye(6)])
        poses = np.repeat(model_angles[None], 7, axis=0)
        rigid = replace(
            self.robot,
            placed=tuple(placed_effect for placed_effect in self.robot.placed if not drives.turns(placed_effect)),
        )
        displacement = solve_balance(rigid, poses, unit, self.setup).displacement[:, 0]
        compliance = (displacement[1:] - displacement[0]).T
        return np.asarray(0.5 * (compliance + compliance.T))


class _Drives:
    """The drives' laws in one pose, tabled: how far each gives under a torque, play included."""

    def __init__(self, robot: CompliantRobot, angles: Floats) -> None:
        chain = robot.chain
        self._inverse = np.linalg.inv(chain.drive_axes)
        steps = np.sinh(_CROWDING * np.linspace(-1.0, 1.0, _TABLE)) / np.sinh(_CROWDING)
        self.torque = 1e5 * steps
        self.angle = np.zeros((chain.n_joints, _TABLE))
        self._robot, self._angles = robot, angles
        for joint in range(chain.n_joints):
            self.angle[joint] = self._give(robot, joint, self.torque) + _RIGID * self.torque

    def _give(self, robot: CompliantRobot, joint: int, torque: Floats) -> Floats:
        chain = robot.chain
        wrench = np.zeros((tool_node(chain) + 1, 6, torque.size))
        for k, share in enumerate(self._inverse.T[:, joint]):
            wrench[joint_node(k + 1), RZ] = share * torque
        loads = NodeLoads(wrench, np.repeat(self._angles[:, None], torque.size, axis=1))
        small = node_displacements(robot, law_terms(robot, loads), torque.size)
        turns = np.stack([small[joint_node(k + 1), RZ] for k in range(chain.n_joints)])
        return np.asarray(self._inverse[joint] @ turns)

    def turns(self, placed_effect: object) -> bool:
        """Return True where an effect turns a drive under its own torque: it is in the table."""
        alone = replace(
            self._robot, placed=tuple(candidate for candidate in self._robot.placed if candidate is placed_effect)
        )
        # every law gives under the largest torque of one sense at least
        largest = self.torque[[0, -1]]
        return any(np.any(self._give(alone, joint, largest)) for joint in range(self._robot.chain.n_joints))

    def angle_of(self, torque: Floats) -> Floats:
        """Return (s, J) rad under torques (s, J), N·m."""
        return np.stack([np.interp(torque[:, k], self.torque, row) for k, row in enumerate(self.angle)], axis=1)

    def torque_of(self, angle: Floats) -> Floats:
        """Return (s, J) N·m at angles (s, J), rad."""
        return np.stack([np.interp(angle[:, k], row, self.torque) for k, row in enumerate(self.angle)], axis=1)

    def stiffness(self, angle: Floats) -> Floats:
        """Return (s, J) N·m/rad at angles (s, J), rad."""
        slopes = []
        for k, row in enumerate(self.angle):
            at = np.clip(np.searchsorted(row, angle[:, k]) - 1, 0, _TABLE - 2)
            slopes.append((self.torque[at + 1] - self.torque[at]) / (row[at + 1] - row[at]))
        return np.stack(slopes, axis=1)


def _newton(coupling: Floats, stiffness: Floats, left: Floats) -> Floats:
    """Return (s, J) rad by which the drives' angles are too large: (1 + C diag(k))⁻¹ left."""
    matrix = np.eye(len(coupling)) + coupling[None] * stiffness[:, None, :]
    return np.asarray(np.linalg.solve(matrix, left[:, :, None])[:, :, 0])


def _first_order(drives: _Drives, motion: Floats, coupling: Floats, sagged: Floats, weight: Floats) -> Floats:
    """Return (s, J) the drives' angles in first order: δ + C (τ(δ) − weight) + motion = 0, by damped Newton steps."""
    angle, step = -motion, np.ones(len(motion))

    def left_of(at: Floats) -> Floats:
        return np.asarray(at + (drives.torque_of(at + sagged) - weight) @ coupling.T + motion)

    residual = left_of(angle)
    for _ in range(200):
        size = np.sqrt(np.sum(residual**2, axis=1))
        if size.max() < SETTLED:
            break
        tried = angle - step[:, None] * _newton(coupling, drives.stiffness(angle + sagged), residual)
        next_residual = left_of(tried)
        better = np.sqrt(np.sum(next_residual**2, axis=1)) < size
        angle, residual = np.where(better[:, None], tried, angle), np.where(better[:, None], next_residual, residual)
        step = np.where(better, np.minimum(2.0 * step, 1.0), 0.5 * step)
    return angle


class ClampedSimulation(RunSimulation[Clamping]):
    """Runs in which a fixture holds the flange."""

    settings = Clamping

    def extent(self, motion: Clamping) -> tuple[float, float]:
        """Return balances and seconds of a run."""
        return 2.0 * motion.cycles * motion.points, motion.cycles * motion.period_s + 2.0 * motion.rest_s

    def frames(self, motion: Clamping) -> tuple[tuple[str, str], ...]:
        """Return the frame that the fixture holds."""
        return (("clamped.point", motion.point),)

    def plan(self, motion: Clamping, setup: RunSetup) -> PlannedRun:
        """Return sweeps; the fixture holds the robot where its loads would act."""
        joints = np.deg2rad(np.array(setup.run.joints_deg))
        loads = setup.loads.model_copy(update={"point": motion.point})
        program = sweep_program(motion, joints, setup.driven_joint())
        return PlannedRun(setup.run.id, joints, program, loads, setup.frames[motion.point], setup.start_s)

    def true_run(
        self,
        robot: CompliantRobot,
        planned: PlannedRun,
        frames: Mapping[str, Attachment],
        tool: ToolWeight,
        motion: Clamping,
    ) -> TrueRun:
        """Find the fixture's wrench all along the sweeps."""
        return simulate_clamped(robot, planned, frames, tool, np.diag(motion.fixture_compliance))
