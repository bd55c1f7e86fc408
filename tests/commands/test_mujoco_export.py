"""`export -o robot.xml`: MuJoCo, which knows nothing of stiffcal, lets the robot sag as `predict` says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.export import export_campaign
from stiffcal.compensation.exports.mujoco_model import mujoco_model, springs_of_block
from stiffcal.compensation.prediction import predict_states
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from tests.compensation.test_step import every_law, everything_linear, springs_36
from tests.laboratory.robots import force_sensor_setup, six_axis_joints

TRUE_ROBOT = Path(__file__).parents[2] / "campaigns" / "irb4400" / "compensation"
SAG = 1e-3
"""Share of the deflection."""
AT_REST = 1e-13
"""rad or m in a millisecond: a heavy link on a soft spring creeps for seconds, with 1e-11 in a millisecond micrometres
before it is at rest."""


def deflections(text: str, target: str, angles: Floats, wrench: Floats) -> Floats:
    """Return (n, 3) m how the target moves by loads (n, 6), base axes, on the robot at commanded angles (n, J)."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    point, site = model.site("load_point"), model.site(target)
    moved = []
    for pose, load in zip(angles, wrench, strict=True):
        places = []
        for share in (0.0, 1.0):
            if share == 0.0:
                mujoco.mj_resetData(model, data)
                for k, angle in enumerate(pose, start=1):
                    data.joint(f"joint{k}").qpos[0] = angle
                mujoco.mj_forward(model, data)
                data.ctrl[:] = data.actuator_length
            for _ in range(100_000):
                data.qfrc_applied[:] = 0.0
                body = int(model.site_bodyid[point.id])
                there = data.site_xpos[point.id].copy()
                mujoco.mj_applyFT(model, data, share * load[:3], share * load[3:], there, body, data.qfrc_applied)
                mujoco.mj_step(model, data)
                if np.abs(data.qvel).max() * model.opt.timestep < AT_REST:
                    break
            assert np.abs(data.qvel).max() * model.opt.timestep < AT_REST
            mujoco.mj_kinematics(model, data)
            places.append(data.site_xpos[site.id].copy())
        moved.append(places[1] - places[0])
    return np.array(moved)


def lengths(text: str, angles: Floats) -> Floats:
    """Return (n, J) rad, the controls that command model angles (n, J)."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    rows = []
    for pose in angles:
        for k, angle in enumerate(pose, start=1):
            data.joint(f"joint{k}").qpos[0] = angle
        mujoco.mj_forward(model, data)
        rows.append(data.actuator_length.copy())
    return np.array(rows)


def loads(rng: np.random.Generator, n: int) -> Floats:
    return np.asarray(rng.normal(size=(n, 6)) * np.repeat([400.0, 60.0], 3))


def predicted(robot: CompliantRobot, setup: MeasurementSetup, joints: Floats, wrench: Floats) -> Floats:
    return np.asarray(predict_states(robot, joints, wrench, setup).deflection[:, :3])


def test_a_campaign_sags_as_predict_says(tmp_path: Path) -> None:
    """Drives and bearings of an ABB IRB 4400, with weight, at six poses."""
    answer = export_campaign(TRUE_ROBOT, RunContext(), tmp_path / "robot.xml")
    text = (tmp_path / "robot.xml").read_text(encoding="utf-8")
    assert "NOT VERIFIED" in text
    assert any(warning.startswith("NOT VERIFIED") for warning in answer.warnings)
    fitted = fitted_robot(load_campaign(TRUE_ROBOT, check_files=False), RunContext())
    rng = np.random.default_rng(4)
    joints, wrench = six_axis_joints(rng, 6), loads(rng, 6)
    chain = fitted.robot.chain
    angles = chain.model_angles(joints)
    assert "WITHOUT COUNTERPART" not in text  # the second drive turns two joints: a servo on a tendon
    theirs = deflections(text, f"target_{fitted.setup.target_names[0]}", angles, wrench)
    ours = predicted(fitted.robot, fitted.setup, joints, wrench)
    controls = np.linalg.solve(chain.coupling, (angles - chain.offset).T).T + np.linalg.solve(
        chain.coupling, chain.offset
    )
    assert lengths(text, angles) == pytest.approx(controls, abs=1e-12)  # as the head states them
    miss = np.linalg.norm(theirs - ours, axis=1) / np.linalg.norm(ours, axis=1)
    assert np.linalg.norm(ours, axis=1).min() > 1e-4
    assert miss.max() < SAG


@pytest.mark.parametrize(
    ("make", "lacking"),
    [
        (everything_linear, ["axis-coupling j5-j6: couples nodes with each other"]),
        (every_law, [
            "backlash j4: not proportional to its load", "two-slope j3: not proportional to its load",
            "friction-hysteresis j2: not proportional to its load",
            "asymmetric-stiffness j1: not proportional to its load",
            "periodic-stiffness j5: not proportional to its load", "cubic-stiffness j6: not proportional to its load",
            "gravity-compensator j2: an additional torque on the joint",
            "friction-hysteresis j5: not proportional to its load", "bearing-tilt j3: not proportional to its load",
            "cubic-stiffness j2: not proportional to its load",
        ]),
    ],
)  # fmt: skip
def test_bearings_links_base_and_tool_sag_and_what_has_no_counterpart_is_named(
    make: object, lacking: list[str]
) -> None:
    robot: CompliantRobot = make()  # type: ignore[operator]
    chain = robot.chain
    setup = force_sensor_setup(chain, 10.0, (0.0, 0.01, 0.1))
    model = mujoco_model(robot, setup, ["a -- test -->"], "robot")
    assert list(model.without_counterpart) == lacking
    head = model.text.split("-->")[0]
    assert all(f"WITHOUT COUNTERPART HERE, omitted: {entry}" in head for entry in lacking)
    held = replace(robot, placed=tuple(placed for placed in robot.placed if placed.effect.name != "axis-coupling"))
    if make is every_law:
        held = springs_36()
    rng = np.random.default_rng(5)
    joints, wrench = six_axis_joints(rng, 3), loads(rng, 3)
    theirs = deflections(model.text, f"target_{setup.target_names[0]}", chain.model_angles(joints), wrench)
    ours = predicted(held, setup, joints, wrench)
    assert (np.linalg.norm(theirs - ours, axis=1) / np.linalg.norm(ours, axis=1)).max() < SAG


def test_a_beam_is_a_hinge_at_half_its_length_and_a_slide() -> None:
    length, rigidity = 0.9, 2e6
    block = np.zeros((6, 6))
    block[2, 2], block[4, 4] = length**3 / (3.0 * rigidity), length / rigidity
    block[2, 4] = block[4, 2] = -(length**2) / (2.0 * rigidity)
    slide, hinge = springs_of_block(block) or []
    assert (slide.hinge, hinge.hinge) == (False, True)
    np.testing.assert_allclose(hinge.point, [-0.5 * length, 0.0, 0.0], atol=1e-12)
    assert slide.compliance == pytest.approx(length**3 / (12.0 * rigidity))
    block[3, 3] = 1e-7
    block[0, 3] = block[3, 0] = 1e-8
    block[0, 0] = 1e-8
    assert springs_of_block(block) is None  # a screw
