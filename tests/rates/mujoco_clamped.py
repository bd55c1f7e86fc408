"""Clamped joints by MuJoCo: one joint on a bench, and a robot of six joints whose flange is held.

The bench is a chain of hinges about one axis: the joint's spring, then what is hidden, each with MuJoCo's own spring,
dry friction, stops or damper (`tests.laboratory.mujoco_path`).

The robot: six joints and rigid links leave a held flange no second place, so that every joint stays where it was when
the flange was clamped. What the motor turns its drive must give, which alone decides the drive's torque; the fixture's
wrench follows from the Jacobian. MuJoCo finds where the weight bends the robot to, the torques of the weight and the
Jacobian there; the laws are those of `tests.laboratory.mujoco_laws`. No law and no mechanics of the package is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.simulation.played.motion import MotionProgram
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight, TrueRun
from tests.laboratory.mujoco_laws import DriveLaw, MujocoDrives
from tests.laboratory.mujoco_path import MujocoPath
from tests.laboratory.mujoco_robot import MujocoRobot, Spring
from tests.laboratory.robots import chain_from_rows, shifted
from tests.rates.mujoco_player import laws_of

BENCH = chain_from_rows("bench", ((0.0, 0.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0)),), shifted(1.0, 0.0, 0.0))
GROUND, TIP = Attachment(0, np.eye(4)), Attachment(2, np.eye(4))


def hinge_of(name: str, values: Mapping[str, float]) -> Spring | None:
    """Return the hinge that gives way as an effect does, None where MuJoCo has none.

    Parameters
    ----------
    values : of `tests.rates.benches.CLAMPED`. A soft spring between stops is a knee, never a play with rounded ends.
    """
    if name == "friction-hysteresis":
        return Spring(1, "turn", 1.0 / values["c"], friction=values["slip"])
    if name == "creep":
        return Spring(1, "turn", 1.0 / values["c"], time=values["time"])
    if name == "two-slope":
        return Spring(1, "turn", 1.0 / values["c"], reach=values["c"] * values["knee"])
    return None


def bench_angle(torque: Floats, time: Floats, stiffness: float, hinges: Sequence[Spring]) -> Floats:
    """Return (n,) rad by which a locked joint's drive turns under torques (n,), N·m, at times (n,), s, from rest."""
    setup = MeasurementSetup(
        wrench_axes=TIP, wrench_point=TIP, targets=(TIP,), target_names=("tip",), moments_measured=True,
    )  # fmt: skip
    wrench = np.zeros((torque.size, 6))
    wrench[:, 5] = torque
    robot = MujocoRobot(BENCH, np.array([stiffness]), setup, hinges, weights=False)
    run = np.zeros(torque.size, dtype=np.int64)
    place = MujocoPath(robot, ramp=1).walk(np.zeros((torque.size, 1)), wrench, run, time).position[:, 0]
    return np.asarray(np.arctan2(place[:, 1], place[:, 0]))


def clamped_by_mujoco(
    robot: CompliantRobot, planned: PlannedRun, frames: Mapping[str, Attachment], tool: ToolWeight, fixture: Floats
) -> TrueRun:
    """Play one clamped run of a robot of six joints, in the place of `stiffcal.kinds.clamped.simulated.simulation`.

    Parameters
    ----------
    robot : joint compliances and laws of single joints. planned : its program is a motion; its load point is where the
        fixture holds. frames : looked at by instruments, on the flange. tool, fixture : nothing hangs on the flange,
        the fixture is rigid.
    """
    program, chain = planned.program, robot.chain
    assert isinstance(program, MotionProgram)
    assert not tool.mass
    assert not fixture.any()
    setup = MeasurementSetup(
        wrench_axes=GROUND, wrench_point=planned.load_point, targets=tuple(frames.values()), target_names=tuple(frames),
        moments_measured=True,
    )  # fmt: skip
    stiffness, laws = np.full(chain.n_joints, np.nan), []
    for one in robot.placed:
        if one.effect.name == "joint-compliance":
            stiffness[one.place.joints[0] - 1] = 1.0 / one.values["c"]
        else:
            laws += laws_of(chain, one)
    angles = chain.model_angles(program.joints)
    drives = MujocoDrives(chain, stiffness, setup, laws=laws)
    at_rest = drives.lead(angles[:1], np.zeros((1, 6)), np.zeros(1, dtype=np.int64), np.zeros(1))
    weight = drives.joint_torque
    held = HeldDrives(stiffness, laws, weight, at_rest.turned[0])
    torque = held.torques(angles, program.node, program.moved_joint - 1)
    # (6, J): the torque about every joint of each unit of the fixture's wrench
    by_wrench = np.stack([drives.joint_force(unit) for unit in np.eye(6)])
    wrench = np.asarray(np.linalg.solve(by_wrench.T, (torque - weight).T).T, dtype=np.float64)
    count, position, unloaded = program.node.size, {}, {}
    for body, name in enumerate(frames):
        start = np.eye(4)
        start[:3, :3], start[:3, 3] = at_rest.rotation[0, body], at_rest.position[0, body]
        position[name], unloaded[name] = np.tile(at_rest.position[0, body], (count, 1)), start
    played = replace(planned, program=replace(program, wrench_at_node=wrench, torque=-torque))
    return TrueRun(played, program.node, position, {name: np.zeros((count, 3)) for name in frames}, unloaded)


@dataclass(frozen=True)
class HeldDrives:
    """Drives whose outboard ends are held.

    Attributes
    ----------
    stiffness : (J,) N·m/rad. laws : what they give beyond their springs.
    torque, turned : (J,) N·m and rad when the flange was clamped.
    """

    stiffness: Floats
    laws: Sequence[DriveLaw]
    torque: Floats
    turned: Floats

    def torques(self, motors: Floats, time: Floats, moved: int) -> Floats:
        """Return (s, J) N·m about the joints while one motor turns.

        Parameters
        ----------
        motors : (s, J) rad, motor angles. time : (s,) s. moved : index of the driven joint.
        """
        torque = np.tile(self.torque, (time.size, 1))
        for k in range(1, time.size):
            lasting = float(time[k] - time[k - 1])
            given = float(self.turned[moved] - (motors[k, moved] - motors[0, moved]))
            torque[k] = self._balance(torque[k - 1], given, moved, (motors[k], lasting))
            for law in self.laws:
                law.settle(torque[k], lasting)
        return torque

    def _balance(self, before: Floats, given: float, moved: int, now: tuple[Floats, float]) -> Floats:
        """Return (J,) N·m at which the moved drive has turned by ``given``, rad; torque rises with the turn."""
        torque = before.copy()

        def excess(value: float) -> float:
            torque[moved] = value
            by_laws = sum(float(law.turn(torque, *now)[moved]) for law in self.laws)
            return value / float(self.stiffness[moved]) + by_laws - given

        last, reach = float(before[moved]), 1.0
        while excess(last - reach) > 0.0 or excess(last + reach) < 0.0:
            reach *= 2.0
        torque[moved] = brentq(excess, last - reach, last + reach, xtol=1e-9, rtol=1e-12)
        return torque
