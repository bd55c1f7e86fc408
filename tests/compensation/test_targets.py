"""Corrected joint targets: reached to a micrometre, with least motion, within limits, and by an outside robot too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.compensation.prediction import predict_states
from stiffcal.compensation.targets import CorrectionOptions, PoseGoal, correct_joints
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.mujoco_robot import MujocoRobot
from tests.laboratory.robots import (
    SEVEN_STIFFNESS,
    SIX_STIFFNESS,
    force_sensor_setup,
    seven_axes,
    six_axes,
    six_axis_joints,
)


def drives(chain: Chain, stiffness: Floats, deformed: bool = True) -> CompliantRobot:
    effect = find_effects()["joint-compliance"]
    placed = (PlacedEffect(effect, Place("joints", (k + 1,)), {"c": 1.0 / c}) for k, c in enumerate(stiffness))
    return CompliantRobot(chain, tuple(placed), deformed)


def regular(chain: Chain, joints: Floats, setup: MeasurementSetup) -> Floats:
    """Return the poses away from singular ones."""
    jacobian = jacobians(chain, chain.model_angles(joints), setup.targets[0])
    return joints[np.linalg.svd(jacobian, compute_uv=False)[:, 5] > 0.05]


def six(n: int) -> tuple[CompliantRobot, MeasurementSetup, Floats, Floats]:
    rng = np.random.default_rng(11)
    chain = six_axes()
    setup = force_sensor_setup(chain, 12.0, (0.0, 0.01, 0.1))
    joints = regular(chain, six_axis_joints(rng, 3 * n), setup)[:n]
    wrench = rng.normal(size=(n, 6)) * np.repeat([400.0, 50.0], 3)
    return drives(chain, SIX_STIFFNESS), setup, joints, wrench


def test_the_loaded_robot_stands_where_the_unloaded_one_would() -> None:
    robot, setup, joints, wrench = six(40)
    found = correct_joints(robot, joints, wrench, setup)
    assert found.reached.all()
    unloaded = solve_balance(robot, robot.chain.model_angles(joints), wrench, setup)
    loaded = solve_balance(robot, robot.chain.model_angles(found.joints), wrench, setup)
    missed = np.linalg.norm(loaded.target_position - unloaded.unloaded_position, axis=2)
    assert missed.max() < 1e-8
    assert np.abs(loaded.target_rotation - unloaded.unloaded_rotation).max() < 1e-8
    moved = np.linalg.norm(found.before[:, :3], axis=1)
    assert 1e-3 < moved.mean() < 1e-2
    assert np.allclose(found.before, found.deflection, atol=1e-12)


def test_ten_poses_by_mujoco() -> None:
    """Deflection within 0.1 % of the outside engine's, and its robot at q′ stands within a micrometre of the goal."""
    robot, setup, joints, wrench = six(10)
    chain = robot.chain
    outside = MujocoRobot(chain, SIX_STIFFNESS, setup)
    loaded = outside.settle(chain.model_angles(joints), wrench)
    unloaded = outside.settle(chain.model_angles(joints), np.zeros_like(wrench))
    theirs = loaded.position[:, 0] - unloaded.position[:, 0]
    in_base = replace(setup, wrench_axes=Attachment(0, np.eye(4)))
    turned = np.einsum("nij,nkj->nki", loaded.sensor_rotation, wrench.reshape(10, 2, 3)).reshape(10, 6)
    ours = predict_states(robot, joints, turned, in_base).deflection[:, :3]
    share = np.linalg.norm(ours - theirs, axis=1) / np.linalg.norm(theirs, axis=1)
    assert share.max() < 1e-3
    corrected = correct_joints(robot, joints, wrench, setup)
    there = outside.settle(chain.model_angles(corrected.joints), wrench)
    assert np.linalg.norm(there.position - unloaded.position, axis=2).max() < 1e-6


def test_seven_joints_by_least_motion() -> None:
    rng = np.random.default_rng(5)
    chain = seven_axes()
    robot, setup = drives(chain, SEVEN_STIFFNESS), force_sensor_setup(chain, 2.0)
    joints, wrench = rng.uniform(-1.2, 1.2, (20, 7)), rng.normal(size=(20, 6)) * np.repeat([60.0, 8.0], 3)
    found = correct_joints(robot, joints, wrench, setup)
    assert found.reached.all()
    moved = found.joints - joints
    jacobian = jacobians(chain, chain.model_angles(found.joints), setup.targets[0])
    # the least motion has no part along which the joints can move and leave the target where it is
    idle = np.linalg.svd(jacobian)[2][:, 6]
    assert np.abs(np.einsum("nj,nj->n", idle, moved)).max() < 2e-3 * np.abs(moved).max()


def test_a_joint_at_its_limit_leaves_the_work_to_the_others() -> None:
    rng = np.random.default_rng(6)
    chain = seven_axes()
    setup = force_sensor_setup(chain, 2.0)
    joints, wrench = rng.uniform(-1.2, 1.2, (1, 7)), rng.normal(size=(1, 6)) * np.repeat([60.0, 8.0], 3)
    free = correct_joints(drives(chain, SEVEN_STIFFNESS), joints, wrench, setup)
    joint = int(np.argmax(free.joints - joints))
    limits = np.tile([-3.0, 3.0], (7, 1))
    limits[joint, 1] = joints[0, joint] + 0.3 * (free.joints - joints)[0, joint]
    narrow = replace(chain, limits=limits)
    found = correct_joints(drives(narrow, SEVEN_STIFFNESS), joints, wrench, setup)
    assert found.reached.all()
    assert found.held == ((chain.joint_names[joint],),)
    assert found.joints[0, joint] == pytest.approx(limits[joint, 1], abs=1e-12)


def test_six_joints_and_a_limit_cannot_keep_the_whole_pose() -> None:
    robot, setup, joints, wrench = six(1)
    free = correct_joints(robot, joints, wrench, setup)
    moved = (free.joints - joints)[0]
    limits = np.tile([-7.0, 7.0], (6, 1))
    limits[3] = sorted([joints[0, 3] - np.sign(moved[3]) * 1.0, joints[0, 3] + 0.2 * moved[3]])
    narrow = replace(robot.chain, limits=limits)
    found = correct_joints(replace(robot, chain=narrow), joints, wrench, setup)
    assert not found.reached[0]
    assert found.position_reached[0]
    assert "A4" in found.held[0]
    assert np.all((found.joints >= limits[:, 0]) & (found.joints <= limits[:, 1]))


def test_next_to_a_singular_pose_the_position_is_kept() -> None:
    """With A5 stretched no joint turns the wrist about one axis; what bearings give about it cannot be taken back."""
    robot, setup, joints, wrench = six(4)
    joints[:, 4] = 1e-4
    drives_alone = correct_joints(robot, joints, wrench, setup)
    assert drives_alone.reached.all()  # what the drives give they can take back anywhere
    tilt = PlacedEffect(find_effects()["bearing-tilt"], Place("joints", (4,)), {"x": 3e-6, "y": 5e-6})
    found = correct_joints(replace(robot, placed=(*robot.placed, tilt)), joints, wrench, setup)
    assert not found.reached.any()
    assert found.position_reached.all()
    assert np.abs(found.joints - joints).max() < np.radians(5.0)


def test_a_pose_in_space_takes_the_sag_out_too() -> None:
    robot, setup, joints, wrench = six(10)
    goal = PoseGoal(*attached_poses(robot.chain, robot.chain.model_angles(joints), setup.targets[0]))
    found = correct_joints(robot, joints, wrench, setup, CorrectionOptions(goal))
    assert found.reached.all()
    loaded = solve_balance(robot, robot.chain.model_angles(found.joints), wrench, setup)
    assert np.abs(loaded.target_position[:, 0] - goal.position).max() < 1e-8
    alone = solve_balance(robot, robot.chain.model_angles(joints), wrench, setup)
    sag = alone.unloaded_position[:, 0] - goal.position
    assert np.allclose(found.before[:, :3], found.deflection[:, :3] + sag, atol=1e-12)
    assert np.abs(sag).max() > 1e-3


def test_the_linear_form_is_corrected_in_its_own_terms() -> None:
    robot, setup, joints, wrench = six(5)
    linear = replace(robot, deformed=False)
    found = correct_joints(linear, joints, wrench, setup)
    assert found.reached.all()
    exact = correct_joints(robot, joints, wrench, setup)
    assert np.allclose(found.joints, exact.joints, atol=0.05 * np.abs(exact.joints - joints).max())
    assert not np.allclose(found.joints, exact.joints, atol=1e-6)


def test_position_alone() -> None:
    robot, setup, joints, wrench = six(5)
    found = correct_joints(robot, joints, wrench, setup, CorrectionOptions(orientation=False))
    whole = correct_joints(robot, joints, wrench, setup)
    assert found.reached.all()
    assert np.abs(found.after[:, 3:]).max() > 1e-5
    assert np.all(np.linalg.norm(found.joints - joints, axis=1) < np.linalg.norm(whole.joints - joints, axis=1))


@pytest.mark.parametrize("weight", [False, True])
def test_what_the_models_uncertainty_leaves_covers_what_is_left(weight: bool) -> None:
    """Robots drawn from the parameters' covariance, with the joints of the mean robot, miss by what is printed."""
    rng = np.random.default_rng(3)
    robot, setup, joints, wrench = six(4)
    chain = robot.chain
    names = [f"joint-compliance.j{k + 1}.c" for k in range(6)]
    root = np.diag(0.02 / SIX_STIFFNESS) @ np.tril(rng.uniform(-0.5, 1.0, (6, 6)))
    matrix = root @ root.T
    covariance = {a: {b: float(matrix[i, j]) for j, b in enumerate(names)} for i, a in enumerate(names)}
    goal = PoseGoal(*attached_poses(chain, chain.model_angles(joints), setup.targets[0])) if weight else None
    found = correct_joints(robot, joints, wrench, setup, CorrectionOptions(goal), covariance)
    share = []
    for _ in range(40):
        values = 1.0 / SIX_STIFFNESS + root @ rng.standard_normal(6)
        other = robot.with_values(dict(zip(names, values.tolist(), strict=True)))
        at = solve_balance(other, chain.model_angles(found.joints), wrench, setup)
        if goal is not None:
            missed = at.target_position[:, 0] - goal.position
        else:
            own = solve_balance(other, chain.model_angles(joints), wrench, setup).unloaded_position[:, 0]
            missed = at.target_position[:, 0] - own
        share.append(missed**2 / np.einsum("nii->ni", found.covariance)[:, :3])
    assert float(np.mean(share)) == pytest.approx(1.0, abs=0.35)
