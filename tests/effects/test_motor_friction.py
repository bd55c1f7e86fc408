"""friction-hysteresis where a clamped motor's torque is measured: the form [coulomb per_Nm]."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.documents import document_of
from stiffcal.effects.friction_hysteresis import FrictionHysteresis
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.rest import find_rest
from stiffcal.model.effect import RZ, Inputs, Place, joint_node
from stiffcal.model.forms import MotorFriction, form_of, whole_form
from stiffcal.model.laws.drives import drive_torque
from tests.laboratory.effect_bench import bare_states, order_of, robot_chain
from tests.laboratory.robots import force_sensor_setup

FORM = cast("MotorFriction", form_of(FrictionHysteresis(), ["coulomb", "per_Nm"]))
PLACE = Place("joints", (2,))
ONE_RUN = np.zeros(6, dtype=np.int64)
# Of the simulated drive: N·m/rad, N·m, 1. Size of the published reducers.
STIFFNESS, COULOMB, SHARE = 900.0, 5.0, 0.1
# Noise of its torque and of its angle: ten times that of the logs of the published reducers, to the encoder's step.
TORQUE_NOISE, ANGLE_NOISE = 0.05, 2e-5
RATE = 50.0

ROBOT = """schema = "stiffcal/robot/1"
name = "one joint"
convention = "modified-dh"
gravity_mps2 = [0, 0, 0]

[[joints]]
name = "output"
"""
MANIFEST = """schema = "stiffcal/campaign/1"
name = "bench"
robot = "robot.toml"

[sources.bench]
time = { rate_hz = 50.0 }
joints = { position = ["angle"], torque = ["torque"], units = { position = "rad", torque = "N*m" } }

[[runs]]
id = "sweep"
experiment = "clamped"
moved_joint = 1
files = { bench = "raw/sweep.csv" }
"""
MODEL = """schema = "stiffcal/model/1"

[[effects]]
type = "joint-compliance"
joints = [1]

[[effects]]
type = "friction-hysteresis"
joints = [1]
[effects.parameters]
"friction-hysteresis.j1.coulomb" = { value = 2.0 }
"friction-hysteresis.j1.per_Nm" = { value = 0.0 }
"""


def behind(torque: list[float], coulomb: float, share: float, weight: Floats | None = None) -> Floats:
    values = {"coulomb": coulomb, "per_Nm": share}
    spring = FORM.spring_torque(PLACE, np.array(torque), ONE_RUN[: len(torque)], weight, values)
    assert spring is not None
    return spring


def test_by_hand() -> None:
    """Up to 22: 22 = s + 2 + s/10, s = 200/11. It stays until s = τ + 2 + s/10, at τ = 14.36; at 7 it is 9/0.9."""
    up = 20.0 / 1.1
    np.testing.assert_allclose(
        behind([0.0, 1.0, 22.0, 15.0, 7.0, -24.0], 2.0, 0.1), [0.0, 0.0, up, up, 10.0, -up * 1.1]
    )


def test_a_run_begins_with_the_weight_on_the_spring() -> None:
    np.testing.assert_allclose(behind([10.0, 11.0, 14.0], 2.0, 0.0, np.full(3, 10.0)), [10.0, 10.0, 12.0])


def test_without_friction_all_of_the_torque_arrives() -> None:
    assert FORM.spring_torque(PLACE, np.ones(6), ONE_RUN, None, {"coulomb": 0.0, "per_Nm": 0.0}) is None


def test_it_acts_where_the_motors_torque_is_measured_alone() -> None:
    chain, torque = robot_chain(), np.array([10.0, 30.0, 20.0, -30.0])
    law = PlacedEffect(FORM, PLACE, {"coulomb": 5.0, "per_Nm": 0.0})
    robot = CompliantRobot(chain, (PlacedEffect(JointCompliance(), PLACE, {"c": 1e-5}), law), deformed=False)
    inputs = Inputs(np.zeros((6, 4)), np.concatenate([np.zeros((5, 4)), torque[None]]), force_sensor_setup(chain))
    node = joint_node(2)
    sensor = find_rest(robot, inputs, order_of([0] * 4)).wrench[node, RZ]
    motor = replace(order_of([0] * 4), motor_torque=np.ones(4, dtype=np.bool_))
    mixed = replace(order_of([0] * 4), motor_torque=np.array([True, True, True, False]))
    spring = find_rest(robot, inputs, motor).wrench[node, RZ]
    assert np.abs(spring - sensor).max() > 1.0
    np.testing.assert_array_equal(find_rest(robot, inputs, mixed).wrench[node, RZ], [*spring[:3], sensor[3]])


def test_it_replaces_the_other_form_where_all_loads_are_motor_torques() -> None:
    states = bare_states([0, 0, 0])
    motors = replace(
        states, runs=tuple(replace(run, measures=StateMeasure.MOTOR_ANGLE, motor_torque=True) for run in states.runs)
    )
    assert whole_form(FrictionHysteresis(), robot_chain(), states) is None
    assert whole_form(FrictionHysteresis(), robot_chain(), motors) is FORM
    # the angle stays while the torque falls from 30 to 18
    angle, torque = np.array([0.0, 1.0, 2.0, 2.0, 2.0, 1.0]), np.array([6.0, 18.0, 30.0, 25.0, 18.0, 6.0])
    assert FORM.start(torque, angle) == {"coulomb": 6.0, "per_Nm": 0.0}


def sweep(seed: int) -> Floats:
    """Return (n, 2) angle, rad, and motor's torque, N·m: friction opposes the motion, and turns round at rest.

    The drive is made from the spring's side, by where it moves to: no play operator is in it.
    """
    angles, torques = [np.zeros(100)], [np.linspace(0.0, COULOMB, 100)]
    spring, direction = 0.0, 1.0
    for target in [30.0, -30.0] * 3 + [0.0]:
        if np.sign(target - spring) != direction:
            loss = COULOMB + SHARE * abs(spring)
            angles.append(np.full(100, spring / STIFFNESS))
            torques.append(np.linspace(spring + direction * loss, spring - direction * loss, 100))
            direction = -direction
        moved = np.linspace(spring, target, 400)
        angles.append(moved / STIFFNESS)
        torques.append(moved + direction * (COULOMB + SHARE * np.abs(moved)))
        spring = target
    rng = np.random.default_rng(seed)
    angle, torque = np.concatenate(angles), np.concatenate(torques)
    noise = rng.standard_normal((2, angle.size))
    return np.stack([angle + ANGLE_NOISE * noise[0], torque + TORQUE_NOISE * noise[1]], axis=1)


def campaign(folder: Path, seed: int) -> Path:
    """Write the campaign of one simulated bench."""
    (folder / "raw").mkdir(parents=True)
    for name, text in (("robot.toml", ROBOT), ("campaign.toml", MANIFEST), ("model.toml", MODEL)):
        (folder / name).write_text(text, "utf-8")
    rows = "\n".join(f"{angle!r},{torque!r}" for angle, torque in sweep(seed).tolist())
    (folder / "raw" / "sweep.csv").write_text("angle,torque\n" + rows + "\n", "utf-8")
    return folder


@pytest.fixture(scope="module")
def parameters(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, tuple[float, float]]]:
    """Value and standard uncertainty of each parameter, for each of two benches."""
    fits = []
    for seed in range(2):
        document = document_of(identify_campaign(campaign(tmp_path_factory.mktemp("bench") / "motor", seed)))
        fits.append({entry["name"]: (entry["value"], entry["std"]) for entry in document["parameters"]})
    return fits


@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("friction-hysteresis.j1.coulomb", COULOMB),
        ("friction-hysteresis.j1.per_Nm", SHARE),
        ("joint-compliance.j1.c", 1.0 / STIFFNESS),
    ],
)
def test_a_simulated_bench_gives_its_parameters_back(
    parameters: list[dict[str, tuple[float, float]]], name: str, truth: float
) -> None:
    values = np.array([fit[name] for fit in parameters])
    # Not by the stated uncertainties: they leave out that all states up to the next motion share the error of the
    # torque at a turning point (`Limits`). Three times that: 0.05 N·m of 30, over √6 turning points, on a share of 0.1.
    assert values[:, 0] == pytest.approx(truth, rel=3.0 * TORQUE_NOISE / 30.0 / np.sqrt(6.0) / SHARE)


def test_a_controllers_code_leaves_it_out() -> None:
    """The load at the tool acts on the spring from its other side."""
    assert tuple(FORM.scalar_laws(PLACE, robot_chain(), {"coulomb": 5.0, "per_Nm": 0.1})) == ()


def test_a_drive_that_turns_two_joints_loses_its_own_torque_alone() -> None:
    """τ_drive = Mᵀ τ_model: friction in drive 3 leaves what all other drives carry as it was."""
    chain = load_campaign(Path(__file__).parents[2] / "campaigns" / "irb4400", check_files=False).chain
    assert not np.array_equal(chain.drive_axes, np.eye(6))
    law = PlacedEffect(FORM, Place("joints", (3,)), {"coulomb": 5.0, "per_Nm": 0.0})
    inputs = Inputs(np.full((6, 4), 0.3), np.array([[20.0], [50.0], [-400.0], [0.0], [0.0], [0.0]]) * [1.0, 2, 3, 2.5],
                    force_sensor_setup(chain))  # fmt: skip
    motor = replace(order_of([0] * 4), motor_torque=np.ones(4, dtype=np.bool_))
    before = find_rest(CompliantRobot(chain, (), deformed=False), inputs, motor).wrench
    after = find_rest(CompliantRobot(chain, (law,), deformed=False), inputs, motor).wrench
    for joint in range(1, 7):
        loss = drive_torque(chain, before, joint) - drive_torque(chain, after, joint)
        if joint == 3:
            np.testing.assert_allclose(np.abs(loss[:3]), 5.0, rtol=1e-9)
        else:
            np.testing.assert_allclose(loss, 0.0, atol=1e-9)
