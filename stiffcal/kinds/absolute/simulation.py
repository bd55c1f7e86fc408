"""Runs of absolute places, simulated: random poses, each at rest under the robot's weight and a payload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.readings.pose_history import rigid_drive_torques
from stiffcal.kinds.absolute.simulation_settings import AbsolutePoses
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.rotations import rotation_from_vector, vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import NoBalanceError, solve_balance
from stiffcal.model.effect import StateOrder
from stiffcal.model.state_order import PoseHistory
from stiffcal.reduction.states.approach import last_motion
from stiffcal.simulation.kinds import RunSetup, RunSimulation
from stiffcal.simulation.played.motion import PoseProgram, pose_program
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight, TrueRun, observed_shift, refuse_setup_effects
from stiffcal.simulation.settings import FILE_NAME

_BASE = Attachment(0, np.eye(4))


class AbsoluteSimulation(RunSimulation[AbsolutePoses]):
    """Runs of absolute places: the links' errors are those of the model file, or drawn from ``[robot]``."""

    settings = AbsolutePoses

    def extent(self, motion: AbsolutePoses) -> tuple[float, float]:
        """Return balances and seconds of a run."""
        return float(motion.poses), motion.poses * motion.interval_s

    def frames(self, motion: AbsolutePoses) -> tuple[tuple[str, str], ...]:
        """Return the frame in which the payload hangs."""
        return (("absolute.point", motion.point),)

    def plan(self, motion: AbsolutePoses, setup: RunSetup) -> PlannedRun:
        """Draw joint angles and payloads."""
        chain = setup.chain
        middle = chain.from_printed(np.array(setup.run.joints_deg))
        spread = chain.from_printed(np.where(chain.prismatic, motion.spread_mm, motion.spread_deg))
        low = np.maximum(middle - spread, chain.limits[:, 0])
        high = np.minimum(middle + spread, chain.limits[:, 1])
        joints = setup.rng.uniform(low, high, (motion.poses, middle.size))
        payload = setup.rng.choice(np.array(motion.payloads_kg), motion.poses)
        loads = setup.loads.model_copy(update={"point": motion.point})
        program = pose_program(joints, payload, motion.interval_s)
        return PlannedRun(setup.run.id, middle, program, loads, setup.frames[motion.point], setup.start_s)

    def true_run(
        self,
        robot: CompliantRobot,
        planned: PlannedRun,
        frames: Mapping[str, Attachment],
        tool: ToolWeight,
        motion: AbsolutePoses,
    ) -> TrueRun:
        """Find where the robot rests in every pose."""
        program = planned.program
        assert isinstance(program, PoseProgram)
        refuse_setup_effects(robot)
        wrench = np.zeros((len(program), 6))
        wrench[:, :3] = program.payload[:, None] * robot.chain.gravity
        setup = MeasurementSetup(
            wrench_axes=_BASE,
            wrench_point=planned.load_point,
            targets=tuple(frames.values()),
            target_names=tuple(frames),
            moments_measured=True,
            tool_mass=tool.mass,
            tool_com=tool.com,
        )
        order = _order_of(robot, planned, program, wrench, setup)
        try:
            balance = solve_balance(robot, robot.chain.model_angles(program.joints), wrench, setup, order)
        except NoBalanceError as error:
            place = f'runs "{planned.name}"'
            raise error.of_load(FILE_NAME, place, "lower absolute.payloads_kg, or stiffen model.toml") from None
        shift = observed_shift(robot, balance.displacement, order)
        rotation = rotation_from_vector(shift[..., 3:]) @ balance.target_rotation
        places = balance.target_position + shift[..., :3]
        position, turn, unloaded = {}, {}, {}
        for body, name in enumerate(frames):
            start = np.eye(4)
            start[:3, :3], start[:3, 3] = rotation[0, body], places[0, body]
            position[name], unloaded[name] = places[:, body], start
            turn[name] = vector_from_rotation(rotation[:, body] @ start[:3, :3].T)
        torque = -(balance.joint_torque @ robot.chain.drive_axes)
        solved = replace(program, wrench=wrench, wrench_at_node=wrench, torque=torque)
        return TrueRun(replace(planned, program=solved), program.node, position, turn, unloaded)


def _order_of(
    robot: CompliantRobot, planned: PlannedRun, program: PoseProgram, wrench: Floats, setup: MeasurementSetup
) -> StateOrder:
    """Return the order of the poses: each is a run of its own, drift counts from the first, drives have a memory."""
    size, chain = len(program), robot.chain
    kelvin = planned.kelvin(program.node)
    follows = np.arange(size) > 0
    hold = 0.5 * (program.end - program.start)
    return StateOrder(
        run=np.arange(size),
        time=planned.start_s + program.node,
        hold=hold,
        motor=np.zeros((chain.n_joints, size)),
        temperature=kelvin - kelvin[0],
        since_reference=program.node - program.node[0],
        kelvin=kelvin,
        approach=last_motion(program.joints @ chain.drives_of_logged.T, follows).T,
        history=PoseHistory(
            rigid_drive_torques(chain, program.joints, wrench, setup),
            np.zeros(size, dtype=np.int64),
            planned.start_s + program.node,
            hold,
            np.arange(size),
        ),
    )
