"""Frames: where the manifest puts the instruments on the robot's bodies."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.campaign.checks.frame_checks import frame_faults
from stiffcal.campaign.frames.frames import frames_to_estimate, measurement_setup, resolve_frames
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.manifest_type import manifest_type
from stiffcal.campaign.manifest.tracker_frames import trackers_of_runs
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.robot.transforms import rotation_taking_z_to
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_rpy
from stiffcal.quaternions import rotation_from_quaternion
from tests.laboratory.campaign_folders import DATA, ROBOT


def chain() -> Chain:
    return chain_of(RobotFile.model_validate(tomllib.loads(ROBOT)), Path())


def manifest(**tables: Any) -> Manifest:
    return Manifest.model_validate({"schema": "stiffcal/campaign/1", **tables})


def test_the_three_ways_to_write_a_rotation_agree() -> None:
    """A quarter turn about z, then a point one along x lies along y."""
    half = np.sqrt(0.5)
    ways: list[dict[str, Any]] = [
        {"quaternion_wxyz": [half, 0, 0, half]},
        {"rpy_deg": [0, 0, 90]},
        {"matrix": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]},
    ]
    for way in ways:
        frames = manifest(frames={"a": {"parent": "flange", **way}, "b": {"parent": "a", "xyz_m": [1, 0, 0]}})
        found = resolve_frames(frames, chain())
        assert found["b"].body == 7
        np.testing.assert_allclose(found["b"].transform[:3, 3], [0, 1, 0], atol=1e-12)


def test_rpy_turns_about_fixed_axes_in_the_order_x_y_z() -> None:
    seen = rotation_from_rpy(np.deg2rad([90, 90, 0])) @ np.array([0, 1, 0])
    np.testing.assert_allclose(seen, [1, 0, 0], atol=1e-15)  # y → z by x, z → x by y


def test_quaternion_has_its_scalar_first() -> None:
    np.testing.assert_allclose(rotation_from_quaternion(np.array([0, 1, 0, 0])), np.diag([1, -1, -1]), atol=1e-15)


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.3, -0.2, 0.1), (1e-9, 0, -1), (1e-13, 0, -1)])
def test_shortest_rotation_takes_z_to_the_axis(axis: tuple[float, float, float]) -> None:
    turn = rotation_taking_z_to(axis)[:3, :3]
    unit = np.array(axis) / np.linalg.norm(axis)
    np.testing.assert_allclose(turn[:, 2], unit, atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
    assert np.trace(turn) == pytest.approx(1 + 2 * unit[2], abs=1e-9)  # the angle is that between z and the axis


def test_frames_on_links_base_and_each_other() -> None:
    tables = {
        "tracker": {"parent": "base", "xyz_m": [3, 0, 0]},
        "on_arm": {"parent": "arm", "xyz_m": [0, 0, 0.2]},
        "probe": {"parent": "on_arm", "xyz_m": [0.1, 0, 0]},
    }
    found = resolve_frames(manifest(frames=tables), chain())
    assert [found[name].body for name in ("base", "tracker", "on_arm", "probe", "swing", "flange")] == [
        0,
        0,
        3,
        3,
        2,
        7,
    ]
    np.testing.assert_allclose(found["probe"].transform[:3, 3], [0.1, 0, 0.2])


def test_estimated_frames_carry_what_hangs_on_them() -> None:
    tables = {"mount": {"parent": "flange", "estimate": True}, "target": {"parent": "mount", "xyz_m": [0, 0, 0.1]}}
    frames = manifest(frames=tables)
    assert frames_to_estimate(frames) == ("mount",)
    moved = np.eye(4)
    moved[:3, 3] = [1, 2, 3]
    found = resolve_frames(frames, chain(), {"mount": moved})
    np.testing.assert_allclose(found["target"].transform[:3, 3], [1, 2, 3.1])


def test_setup_of_the_full_example() -> None:
    text = (DATA / "interface_campaign_full.toml").read_text(encoding="utf-8")
    text = text.replace("# sigma = { force = 0.5", "sigma = { force = 0.5")
    full = manifest_type().model_validate(tomllib.loads(text))
    setup = measurement_setup(full, chain(), resolve_frames(full, chain()))
    assert setup.target_names == ("target",)
    assert setup.moments_measured
    assert setup.tool_mass == 12.0
    assert (setup.sigma.force, setup.sigma.moment) == (0.5, 0.1)
    assert setup.sigma.translation == pytest.approx(1.5e-5)  # 0.015 mm
    assert setup.sigma.rotation == pytest.approx(3e-5)
    np.testing.assert_allclose(setup.wrench_point.transform[:3, 3], [0, 0, 0.06])
    assert setup.tared == "run"


def test_setup_of_dead_weights_and_a_gauge() -> None:
    tables = {
        "frames": {"hook": {"parent": "flange"}, "probe": {"parent": "flange"}},
        "sources": {
            "table": {
                "dead_weight": {"mass_column": "kg", "point": "hook", "sigma": {"mass": 0.1}},
                "displacement": {"column": "s", "body": "probe", "direction": [0, 0, 1], "units": {"length": "mm"}},
            }
        },
    }
    found = manifest(**tables)
    setup = measurement_setup(found, chain(), resolve_frames(found, chain()))
    assert setup.wrench_axes.body == 0
    assert setup.wrench_point.body == 7
    assert setup.target_names == ("probe",)
    assert not setup.moments_measured
    assert setup.sigma.force == pytest.approx(0.981)


def test_two_loads_and_two_instruments_of_one_run_are_refused() -> None:
    wrench = {"columns": "f1..f6", "frame": "flange"}
    pose = {"position": "p1..p3", "body": "flange"}
    twice = manifest(sources={"a": {"wrench": wrench}, "b": {"wrench": wrench}})
    with pytest.raises(InputError, match="measured twice"):
        measurement_setup(twice, chain(), resolve_frames(twice, chain()))
    tables = {
        "frames": {"t1": {"parent": "base"}, "t2": {"parent": "base"}},
        "sources": {"a": {"pose": {**pose, "frame": "t1"}}, "b": {"pose": {**pose, "frame": "t2"}}},
    }
    both = {"a": "a.csv", "b": "b.csv"}
    (fault,) = frame_faults(manifest(**tables, runs=[{"id": "1", "files": both}]), ())
    assert (fault.code, fault.place) == (FaultCode.KEY_CONFLICT, "sources.b")
    of_runs = manifest(**tables, runs=[{"id": name, "files": {name: file}} for name, file in both.items()])
    assert not list(frame_faults(of_runs, ()))
    assert trackers_of_runs(of_runs) == {"a": 0, "b": 1}
    setup = measurement_setup(of_runs, chain(), resolve_frames(of_runs, chain()))
    assert [tracker.frame for tracker in setup.trackers] == ["t1", "t2"]
