"""Friction runs: one joint driven to and fro in the air at one velocity after another, and what its drive needs.

The drive carries friction at the velocity of the moment, the weight of everything outboard, the inertia of the moving
masses and of its own rotor, and the ripple of its gear. Servos are taken as perfect: the joint is where it is driven.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.friction.simulated.simulation_settings import FrictionMotion
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rigid_body import drive_matrix, rigid_torque
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.stated_spring import spring_torque
from stiffcal.model.motion import Motion
from stiffcal.simulation.kinds import RunSetup, RunSimulation
from stiffcal.simulation.played.drive_friction import friction_torque
from stiffcal.simulation.played.motion import MotionProgram, motion_program
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight, TrueRun

RAMP_POINTS = 24
# Weight is straight between nodes this far apart to 10⁻⁵ of itself.
NODE_RAD = 0.01
# Friction that builds up after a reversal does so within micro- to milliradians: as many nodes in addition there.
FIRST_RAD, REVERSAL_NODES = (1e-5, 0.03), 48
# A wave of the torque over the angle has at least as many nodes.
NODES_PER_WAVE = 20.0


@dataclass(frozen=True)
class StrokesProgram(MotionProgram):
    """Strokes at constant velocities; velocity and acceleration of the moved joint are known at the nodes."""

    speed: Floats
    """(s,) rad/s."""
    acceleration: Floats
    """(s,) rad/s²."""

    def velocity_at(self, path: Floats) -> Floats:
        """Return (n, L) rad/s at path coordinates."""
        velocity = np.zeros((path.size, self.joints.shape[1]))
        velocity[:, self.moved_joint - 1] = np.interp(path, self.node, self.speed)
        return velocity


def strokes_program(motion: FrictionMotion, joints: Floats, moved_joint: int) -> StrokesProgram:
    """Return the motion of one friction run: rests, and strokes about the pose at one speed after another.

    Parameters
    ----------
    motion : speeds, reach, times.
    joints : (L,) rad, the pose.
    moved_joint : from 1.

    Examples
    --------
    >>> program = strokes_program(FrictionMotion(speeds_rad_s=[0.1, 0.5], amplitude_deg=20.0), np.zeros(6), 2)
    >>> [round(float(each), 3) for each in (program.speed.max(), program.speed.min(), np.ptp(program.joints[:, 0]))]
    [0.5, -0.5, 0.0]
    """
    time, place, speed, acceleration = [np.array([0.0])], [np.zeros(1)], [np.zeros(1)], [np.zeros(1)]
    for requested in motion.speeds_rad_s:
        fastest = requested if motion.reachable_rad_s is None else min(requested, motion.reachable_rad_s)
        length = min(2.0 * np.deg2rad(motion.amplitude_deg), fastest * motion.longest_s)
        directions = [1.0, -1.0] * motion.cycles if motion.both_ways else [1.0]
        moves = [
            (-0.5 * length - float(place[-1][-1]), motion.approach_rad_s),
            *((direction * length, fastest) for direction in directions),
        ]
        for distance, pace in moves:
            for segment in (_rest(motion.rest_s), _stroke(distance, pace, motion.acceleration_rad_s2)):
                time.append(time[-1][-1] + segment[0])
                place.append(place[-1][-1] + segment[1])
                speed.append(segment[2])
                acceleration.append(segment[3])
    node = np.concatenate(time)
    path = np.repeat(joints[None], node.size, axis=0)
    path[:, moved_joint - 1] += np.concatenate(place)
    plain = motion_program(node, path, moved_joint)
    fields = {name: getattr(plain, name) for name in MotionProgram.__dataclass_fields__}
    return StrokesProgram(**fields, speed=np.concatenate(speed), acceleration=np.concatenate(acceleration))


def _rest(seconds: float) -> tuple[Floats, Floats, Floats, Floats]:
    return np.array([seconds]), np.zeros(1), np.zeros(1), np.zeros(1)


def _stroke(distance: float, pace: float, acceleration: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Return times, places, speeds and accelerations of one trapezoidal stroke, after its start."""
    length, direction = abs(distance), float(np.sign(distance))
    if length == 0.0:
        return _rest(0.0)
    pace = min(pace, float(np.sqrt(length * acceleration)))
    ramp = pace / acceleration
    steady = max(length / pace - ramp, 0.0)
    up = np.linspace(0.0, ramp, RAMP_POINTS)
    count = max(2, int(np.ceil(pace * steady / NODE_RAD)))
    early = np.geomspace(*FIRST_RAD, REVERSAL_NODES) / pace
    even = ramp + np.union1d(np.linspace(0.0, steady, count), early[early < steady])
    down = ramp + steady + up
    time = np.concatenate([up, even, down])
    place = np.concatenate(
        [0.5 * acceleration * up**2, pace * (even - 0.5 * ramp), length - 0.5 * acceleration * (ramp - up) ** 2]
    )
    speed = np.concatenate([acceleration * up, np.full(even.size, pace), acceleration * (ramp - up)])
    change = np.concatenate([np.full(up.size, acceleration), np.zeros(even.size), np.full(up.size, -acceleration)])
    # two nodes at one moment: where the acceleration jumps, so does the torque
    time[0] = 1e-9
    time[1:] = np.maximum.accumulate(np.maximum(time[1:], time[:-1] + 1e-9))
    return time, direction * place, direction * speed, direction * change


def simulate_friction(
    robot: CompliantRobot,
    planned: PlannedRun,
    frames: Mapping[str, Attachment],
    tool: ToolWeight,
    motion: FrictionMotion,
) -> TrueRun:
    """Play one friction run.

    Parameters
    ----------
    robot : chain and effects with values; those that show in motion make the friction.
    planned : its program is of `strokes_program`.
    frames : what instruments look at.
    tool : what is mounted on the flange.
    motion : rotor inertia and gear ripple.
    """
    program = planned.program
    assert isinstance(program, StrokesProgram)
    program = _with_nodes_for_waves(program, robot)
    chain, k = robot.chain, program.moved_joint - 1
    velocity, acceleration = np.zeros_like(program.joints), np.zeros_like(program.joints)
    velocity[:, k], acceleration[:, k] = program.speed, program.acceleration
    angles = chain.model_angles(program.joints)
    moving = (rate @ chain.coupling.T for rate in (velocity, acceleration))
    loaded, drives = _with_tool(chain, tool), drive_matrix(chain)
    still, spring = np.zeros_like(angles), spring_torque(chain, angles)
    torque = (rigid_torque(loaded, angles, *moving) - spring) @ drives
    weight = (rigid_torque(loaded, angles, still, still) - spring) @ drives
    torque[:, k] += motion.rotor_inertia_kgm2 * program.acceleration
    torque[:, k] += motion.ripple_Nm * np.sin(motion.ripple_per_turn * program.joints[:, k])
    time = program.node
    torque += friction_torque(robot, program.joints, velocity, weight, time, planned.warmer(time))
    position, turn, unloaded = {}, {}, {}
    for name, frame in frames.items():
        places, rotations = attached_poses(chain, angles, frame)
        start = np.eye(4)
        start[:3, :3], start[:3, 3] = rotations[0], places[0]
        position[name], unloaded[name] = places, start
        turn[name] = vector_from_rotation(rotations @ rotations[0].T)
    return TrueRun(replace(planned, program=replace(program, torque=torque)), program.node, position, turn, unloaded)


def _with_nodes_for_waves(program: StrokesProgram, robot: CompliantRobot) -> StrokesProgram:
    """Return the motion with nodes between its nodes where the model's friction swings with the angle."""
    orders = [
        placed.values.get(spec.symbol, spec.typical)
        for placed in robot.placed
        for spec in placed.effect.parameters
        if isinstance(placed.effect, Motion) and spec.discrete
    ]
    parts = int(np.ceil(NODE_RAD * max(orders, default=0.0) * NODES_PER_WAVE / (2.0 * np.pi)))
    if parts < 2:
        return program
    s = program.node.size
    number = np.linspace(0.0, s - 1.0, (s - 1) * parts + 1)

    def between(values: Floats) -> Floats:
        columns = values.reshape(s, -1).T
        fine = np.stack([np.interp(number, np.arange(s), column) for column in columns], axis=1)
        return fine.reshape(number.size, *values.shape[1:])

    return replace(
        program, node=between(program.node), joints=between(program.joints), torque=between(program.torque),
        wrench_at_node=between(program.wrench_at_node), speed=between(program.speed),
        acceleration=between(program.acceleration),
    )  # fmt: skip


def _with_tool(chain: Chain, tool: ToolWeight) -> Chain:
    """Return the chain with the tool's mass in its last link."""
    if tool.mass == 0.0:
        return chain
    mass, com = chain.link_mass.copy(), chain.link_com.copy()
    place = chain.flange[:3, :3] @ tool.com + chain.flange[:3, 3]
    total_mass = mass[-1] + tool.mass
    com[-1] = (mass[-1] * com[-1] + tool.mass * place) / total_mass
    mass[-1] = total_mass
    return replace(chain, link_mass=mass, link_com=com)


class FrictionSimulation(RunSimulation[FrictionMotion]):
    """Runs in which one joint is driven to and fro in the air."""

    settings = FrictionMotion

    def extent(self, motion: FrictionMotion) -> tuple[float, float]:
        """Return strokes and seconds of a run."""
        strokes = len(motion.speeds_rad_s) * (1.0 + 2.0 * motion.cycles)
        return strokes, strokes * (motion.longest_s + motion.rest_s)

    def plan(self, motion: FrictionMotion, setup: RunSetup) -> PlannedRun:
        """Return strokes about the pose."""
        joints = np.deg2rad(np.array(setup.run.joints_deg))
        program = strokes_program(motion, joints, setup.driven_joint())
        # In free motion no load acts: the load point is not used, and any frame does.
        unused_load_point = Attachment(0, np.eye(4))
        return PlannedRun(setup.run.id, joints, program, setup.loads, unused_load_point, setup.start_s)

    def true_run(
        self,
        robot: CompliantRobot,
        planned: PlannedRun,
        frames: Mapping[str, Attachment],
        tool: ToolWeight,
        motion: FrictionMotion,
    ) -> TrueRun:
        """Find the torque that the drives need."""
        return simulate_friction(robot, planned, frames, tool, motion)
