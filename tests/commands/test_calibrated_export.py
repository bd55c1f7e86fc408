"""The calibrated robot as URDF and as robot file, read again: the fitted rigid robot, and the true one."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign, load_robot
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.commands.export import export_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.compensation.exports.row_options import RowOptions
from stiffcal.mechanics.conventions import Convention
from stiffcal.mechanics.kinematics import attached_poses, body_poses
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.absolute_and_loads import Truth, write_campaign
from tests.laboratory.robots import six_axis_joints

pinocchio = pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")
N_POSES = 1000
MICROMETRE = 1e-6


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Truth]:
    folder = tmp_path_factory.mktemp("calibrated") / "arm"
    truth = write_campaign(folder, 5)
    export_campaign(folder, output=folder / "calibrated.urdf")
    return folder, truth


def test_the_file_is_the_fitted_robot_within_a_micrometre(exported: tuple[Path, Truth]) -> None:
    folder, _ = exported
    data = up_to_date_states(folder, RunContext())
    robot = placed_robot(data.campaign).with_values(identify_campaign(folder).robot_values())
    joints = six_axis_joints(np.random.default_rng(4), N_POSES)
    positions, rotations = body_poses(robot.adjusted_chain, robot.chain.model_angles(joints))
    model = pinocchio.buildModelFromUrdf(str(folder / "calibrated.urdf"))
    memory, flange = model.createData(), model.getFrameId("flange")
    worst = 0.0
    for angles, position, rotation in zip(joints, positions[:, -1], rotations[:, -1], strict=True):
        pinocchio.framesForwardKinematics(model, memory, angles)
        pose = memory.oMf[flange]
        worst = max(worst, float(np.linalg.norm(pose.translation - position)))
        assert np.abs(pose.rotation - rotation).max() < 1e-6
    assert worst < MICROMETRE
    # the nominal robot is millimetres away: it is not what was written
    nominal, _ = body_poses(robot.chain, robot.chain.model_angles(joints))
    assert np.linalg.norm(nominal[:, -1] - positions[:, -1], axis=1).max() > 1e-3


def test_stiffcal_reads_it_as_the_same_robot(exported: tuple[Path, Truth], tmp_path: Path) -> None:
    folder, _ = exported
    robot = placed_robot(load_campaign(folder)).with_values(identify_campaign(folder).robot_values())
    for name in ("campaign.toml", "model.toml", "calibrated.urdf"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    text = 'schema = "stiffcal/robot/1"\nname = "calibrated"\nurdf = "calibrated.urdf"\nbase_link = "base"\n'
    (tmp_path / "robot.toml").write_text(f'{text}tip_link = "flange"\n', encoding="utf-8")
    again = load_campaign(tmp_path, check_files=False).chain
    joints = six_axis_joints(np.random.default_rng(4), N_POSES)
    first, second = (body_poses(chain, chain.model_angles(joints))[0][:, -1] for chain in (robot.adjusted_chain, again))
    assert np.linalg.norm(first - second, axis=1).max() < MICROMETRE
    assert again.link_mass == pytest.approx(robot.chain.link_mass)


def test_from_the_tracker_to_the_target_it_is_the_true_robot(exported: tuple[Path, Truth]) -> None:
    """The tracker's and the target's frames are in the file, so that no convention is left to choose."""
    folder, truth = exported
    model = pinocchio.buildModelFromUrdf(str(folder / "calibrated.urdf"))
    memory = model.createData()
    tracker, target = model.getFrameId("tracker"), model.getFrameId("target")
    joints = six_axis_joints(np.random.default_rng(4), N_POSES)
    places = np.empty((N_POSES, 3))
    for k, angles in enumerate(joints):
        pinocchio.framesForwardKinematics(model, memory, angles)
        places[k] = (memory.oMf[tracker].inverse() * memory.oMf[target]).translation
    attachment = up_to_date_states(folder, RunContext()).states.setup.targets[0]
    frame = np.eye(4)
    frame[:3, 3] = truth.target
    true, _ = attached_poses(truth.chain, truth.chain.model_angles(joints), type(attachment)(attachment.body, frame))
    inverse = np.linalg.inv(truth.tracker_in_base)
    away = places - (true @ inverse[:3, :3].T + inverse[:3, 3])
    # 33 numbers from 180 coordinates known to 20 µm leave 20 µm √3 √(33/180) = 15 µm, and a half of it beyond
    assert np.sqrt(np.mean(np.sum(away**2, axis=1))) < 25e-6


@pytest.mark.parametrize("convention", get_args(Convention))
@pytest.mark.parametrize("strict", [False, True])
def test_the_robot_file_is_the_fitted_robot(
    exported: tuple[Path, Truth], tmp_path: Path, convention: Convention, strict: bool
) -> None:
    """Read again: flange, centres of mass and bearings at 1000 poses; strict rows begin far away, and are warned of."""
    folder, _ = exported
    result = export_campaign(folder, output=tmp_path / "robot.toml", rows=RowOptions(convention, strict))
    assert bool(result.warnings) == strict
    file = load_robot(tmp_path / "robot.toml")
    assert any(entry.beta_deg for entry in file.joints) != strict
    again = chain_of(file, tmp_path)
    robot = placed_robot(load_campaign(folder)).with_values(identify_campaign(folder).robot_values())
    joints = six_axis_joints(np.random.default_rng(4), N_POSES)
    fitted, read = ((*body_poses(chain, chain.model_angles(joints)), chain) for chain in (robot.adjusted_chain, again))
    assert np.linalg.norm(fitted[0][:, -1] - read[0][:, -1], axis=1).max() < MICROMETRE
    assert np.abs(fitted[1][:, -1] - read[1][:, -1]).max() < MICROMETRE
    if strict:
        return  # frames that lie kilometres away carry no masses
    for k in range(6):
        fitted_places, read_places = (
            np.array(
                [
                    place[:, k + 1] + turned[:, k + 1] @ on_link
                    for on_link in (chain.link_com[k], np.array([0.0, 0.0, chain.bearing[k]]))
                ]
            )
            for place, turned, chain in (fitted, read)
        )
        assert np.abs(fitted_places - read_places).max() < MICROMETRE
    assert again.link_mass == pytest.approx(robot.chain.link_mass)
