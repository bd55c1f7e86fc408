"""Friction runs that are simulated: strokes as asked for, and the drive's torque to the last term."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.effects.joint_friction import JointFriction
from stiffcal.effects.presliding import Presliding
from stiffcal.effects.torque_ripple import TorqueRipple
from stiffcal.kinds.friction.simulated.simulation import simulate_friction, strokes_program
from stiffcal.kinds.friction.simulated.simulation_settings import FrictionMotion
from stiffcal.measurements.load_states import Attachment
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.drive_motion import travel_since_reversal
from stiffcal.model.effect import Place
from stiffcal.simulation.played.motion import MotionProgram
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight
from stiffcal.simulation.settings import Loads
from tests.laboratory.friction_law import friction_torque
from tests.laboratory.pinocchio_robot import gravity_torques, pinocchio_model
from tests.laboratory.robots import six_axes

LAW = JointFriction()
VALUES = {"coulomb": 60.0, "viscous": 90.0}
POSE = np.radians([10.0, -60.0, 30.0, 20.0, 40.0, 0.0])
MOTION = FrictionMotion(
    speeds_rad_s=[0.05, 0.8], amplitude_deg=30.0, longest_s=4.0, acceleration_rad_s2=5.0, rotor_inertia_kgm2=25.0,
    ripple_Nm=2.0, ripple_per_turn=80.0,
)  # fmt: skip


def played(tool: ToolWeight) -> MotionProgram:
    chain = six_axes()
    robot = CompliantRobot(chain, (PlacedEffect(LAW, Place("joints", (2,)), VALUES),))
    program = strokes_program(MOTION, POSE, 2)
    planned = PlannedRun("a", POSE, program, Loads(), Attachment(0, np.eye(4)), 0.0)
    done = simulate_friction(robot, planned, {}, tool, MOTION).planned.program
    assert isinstance(done, MotionProgram)
    return done


def test_strokes_are_those_asked_for() -> None:
    program = strokes_program(MOTION, POSE, 2)
    angle = np.degrees(program.joints[:, 1] - POSE[1])
    assert angle.max() == pytest.approx(30.0, abs=1e-6)
    assert angle.min() == pytest.approx(-30.0, abs=1e-6)
    assert np.all(np.diff(program.node) > 0.0)
    # the place is the integral of the speed, which is straight between the nodes
    slope = np.diff(program.joints[:, 1]) / np.diff(program.node)
    middle = 0.5 * (program.speed[1:] + program.speed[:-1])
    long = np.diff(program.node) > 1e-3  # nodes are kept apart by a nanosecond
    np.testing.assert_allclose(slope[long], middle[long], atol=1e-6)
    assert np.ptp(program.joints[:, 0]) == 0.0


@pytest.mark.parametrize("mass", [0.0, 30.0])
def test_the_torque_is_friction_weight_inertia_and_ripple(mass: float) -> None:
    com = np.array([0.02, -0.01, 0.15])
    program = played(ToolWeight(mass, com))
    chain = six_axes()
    model = pinocchio_model(chain, mass, com)
    steady = np.flatnonzero(np.abs(getattr(program, "acceleration")) == 0.0)[::40]  # noqa: B009
    angles = chain.model_angles(program.joints[steady])
    speed: Floats = program.velocity_at(program.node[steady])[:, 1]
    weight = np.array([gravity_torques(model, q)[1] for q in angles])
    wanted = weight + friction_torque(speed, VALUES) + 2.0 * np.sin(80.0 * program.joints[steady, 1])
    np.testing.assert_allclose(program.torque[steady, 1], wanted, rtol=1e-9)


def test_accelerating_takes_the_rotor_and_the_arm() -> None:
    program = played(ToolWeight(0.0, np.zeros(3)))
    change = np.asarray(getattr(program, "acceleration"))  # noqa: B009
    rising = np.flatnonzero((change[:-1] == 5.0) & (change[1:] == 0.0))
    k = int(rising[0])
    # at the end of a ramp place and speed stay, the acceleration goes: 25 kg·m² of rotor, and the arm about joint 2
    jump = float(program.torque[k, 1] - program.torque[k + 1, 1])
    assert jump > 25.0 * 5.0
    assert jump == pytest.approx(5.0 * (25.0 + arm_about_joint_2()), rel=1e-6)


def arm_about_joint_2() -> float:
    """The links' moment of inertia about joint 2's axis in the pose at which the first ramp ends, kg·m²."""
    import pinocchio

    program = strokes_program(MOTION, POSE, 2)
    k = int(np.flatnonzero((program.acceleration[:-1] == 5.0) & (program.acceleration[1:] == 0.0))[0])
    model = pinocchio_model(six_axes())
    mass = pinocchio.crba(model, model.createData(), six_axes().model_angles(program.joints[k : k + 1])[0])
    return float(mass[1, 1])


def test_every_effect_of_moving_joints_is_played() -> None:
    """Laws of load, temperature, angle and travel since the reversal, against the laws as their pages write them."""
    effects = built_in_effects()
    values = {
        "friction-load": {"per_Nm": 0.05}, "friction-temperature": {"coulomb_K": -1.0, "viscous_K": -4.0},
        "torque-ripple": {"a": 2.0, "b": -1.0, "order": 30.0}, "friction-asymmetry": {"offset": 3.0},
        "viscous-power": {"factor": 40.0, "power": 0.5}, "presliding": {"stiffness": 5e4, "angle": 1e-3},
        "stribeck": {"stribeck": 10.0, "velocity": 0.03, "exponent": 1.0},
    }  # fmt: skip
    place = Place("joints", (2,))
    chain, motion = six_axes(), MOTION.model_copy(update={"ripple_Nm": 0.0})
    program = strokes_program(motion, POSE, 2)
    torque = {}
    for name in ("none", *values):
        placed = (PlacedEffect(effects[name], place, values[name]),) if name in values else ()
        planned = PlannedRun("a", POSE, program, Loads(), Attachment(0, np.eye(4)), 3600.0, warming_K_per_hour=5.0)
        played_program = simulate_friction(
            CompliantRobot(chain, placed), planned, {}, ToolWeight(0.0, np.zeros(3)), motion
        ).planned.program
        assert isinstance(played_program, MotionProgram)
        torque[name] = played_program.torque[:, 1]
    speed, angle = program.speed, program.joints[:, 1]
    sign = np.sign(speed)
    model = pinocchio_model(chain)
    weight = np.array([gravity_torques(model, q)[1] for q in chain.model_angles(program.joints)])
    kelvin = 5.0 * (3600.0 + program.node) / 3600.0
    wanted = {
        "friction-load": 0.05 * np.abs(weight) * sign,
        "friction-temperature": kelvin * (-1.0 * sign - 4.0 * speed),
        "torque-ripple": np.where(sign != 0.0, 2.0 * np.cos(30.0 * angle) - np.sin(30.0 * angle), 0.0),
        "friction-asymmetry": np.where(sign != 0.0, 3.0, 0.0),
        "viscous-power": 40.0 * np.sqrt(np.abs(speed)) * sign,
        "stribeck": 10.0 * np.exp(-np.abs(speed) / 0.03) * sign,
    }
    for name, law in wanted.items():
        np.testing.assert_allclose(torque[name] - torque["none"], law, atol=1e-8, err_msg=name)
    missing = torque["presliding"] - torque["none"]
    # Only after a reversal, against the motion, and gone after some milliradians.
    first = np.flatnonzero(np.diff(sign[sign != 0.0]) != 0.0)[0] + 1
    moving = np.flatnonzero(sign != 0.0)
    assert not missing[moving[:first]].any()
    assert np.all(missing[moving[first:]] * sign[moving[first:]] <= 0.0)
    assert np.abs(missing).max() == pytest.approx(50.0, rel=0.05)
    assert np.median(np.abs(missing)) < 0.1


def test_friction_that_builds_up_has_nodes_enough() -> None:
    """Read between the nodes, it is Dahl's to a hundredth, at a speed without a long ramp."""
    robot = CompliantRobot(
        six_axes(), (PlacedEffect(Presliding(), Place("joints", (2,)), {"stiffness": 4e4, "angle": 3e-3}),)
    )
    motion = MOTION.model_copy(update={"ripple_Nm": 0.0, "rotor_inertia_kgm2": 0.0, "speeds_rad_s": [0.015]})
    program = strokes_program(motion, POSE, 2)
    runs = []
    for model in (robot, CompliantRobot(six_axes(), ())):
        planned = PlannedRun("a", POSE, program, Loads(), Attachment(0, np.eye(4)), 0.0)
        done = simulate_friction(model, planned, {}, ToolWeight(0.0, np.zeros(3)), motion).planned.program
        assert isinstance(done, MotionProgram)
        runs.append(done)
    forwards = np.flatnonzero(program.speed == 0.015)
    start = forwards[0]
    turned = program.joints[start - 1 :: -1, 1].min()
    time = np.linspace(program.node[start], program.node[start] + 1.0, 400)
    travel = runs[0].joints_at(time)[:, 1] - turned
    missing = (runs[0].torque_at(time) - runs[1].torque_at(time))[:, 1]
    np.testing.assert_allclose(missing, -120.0 * np.exp(-travel / 3e-3), atol=1.2)


def test_travel_since_the_reversal() -> None:
    angle = np.array([0.0, 0.2, 0.5, 0.5, 0.4, 0.1, 0.1, 0.0, 0.3])
    velocity = np.array([0.0, 1.0, 1.0, 0.0, -1.0, -1.0, 0.0, -1.0, 1.0])
    travel = travel_since_reversal(angle, velocity)
    assert np.isnan(travel[:4]).all()
    np.testing.assert_allclose(travel[4:], [0.1, 0.4, 0.4, 0.5, 0.3], atol=1e-12)
    assert np.isnan(travel_since_reversal(angle, np.zeros(9))).all()


def test_fine_waves_have_nodes_enough() -> None:
    """A reducer's 171 waves a turn, read between the nodes."""
    robot = CompliantRobot(
        six_axes(),
        (PlacedEffect(TorqueRipple(), Place("joints", (2,)), {"a": 50.0, "b": 0.0, "order": 171.0}),),
    )
    motion = MOTION.model_copy(update={"ripple_Nm": 0.0, "rotor_inertia_kgm2": 0.0})
    program = strokes_program(motion, POSE, 2)
    runs = []
    for model in (robot, CompliantRobot(six_axes(), ())):
        planned = PlannedRun("a", POSE, program, Loads(), Attachment(0, np.eye(4)), 0.0)
        done = simulate_friction(model, planned, {}, ToolWeight(0.0, np.zeros(3)), motion).planned.program
        assert isinstance(done, MotionProgram)
        runs.append(done)
    moving = np.flatnonzero((program.acceleration[:-1] == 0.0) & (program.speed[:-1] == program.speed[1:]))
    time = np.interp(np.linspace(0.0, 1.0, 5000), np.linspace(0.0, 1.0, moving.size), program.node[moving])
    time = time[np.abs(runs[0].velocity_at(time)[:, 1]) == 0.05]
    assert time.size > 100
    wave = (runs[0].torque_at(time) - runs[1].torque_at(time))[:, 1]
    wanted = 50.0 * np.cos(171.0 * runs[0].joints_at(time)[:, 1])
    assert np.abs(wave - wanted).max() < 0.02 * 50.0
