"""The wrench of a fixture from the moved motor's torque, against pinocchio's static balance."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.kinds.clamped.held.holding import held_wrench
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.measurements.load_states import RunInfo
from tests.laboratory.pinocchio_robot import gravity_torques, pinocchio_model

pin: Any = pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")

CAMPAIGNS = Path(__file__).resolve().parents[2] / "campaigns"
# a bent pose: no two axes alike, so that every drive turns the flange in a way of its own
POSE = np.array([0.3, -1.1, 1.3, 0.4, 0.9, -0.6])
TORQUE = np.linspace(-300.0, 500.0, 5)


def held_robot(folder: Path, robot: Path) -> Campaign:
    """Return the clamped campaign of kr125 with another robot file and a turned force sensor off the axis."""
    shutil.copytree(CAMPAIGNS / "kr125", folder, ignore=shutil.ignore_patterns("raw", "store"))
    shutil.copyfile(robot, folder / "robot.toml")
    manifest = folder / "campaign.toml"
    text, place = manifest.read_text("utf-8"), "xyz_m = [0.0, 0.0, 0.06]\n"
    assert place in text
    manifest.write_text(text.replace(place, "xyz_m = [0.02, -0.03, 0.06]\nrpy_deg = [20.0, -35.0, 50.0]\n"), "utf-8")
    return load_campaign(folder, check_files=False)


@pytest.fixture(scope="module", params=["with masses", "without masses"])
def campaign(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """A heavy six-axis robot whose masses are known, and one whose masses are not."""
    known = request.param == "with masses"
    robot = CAMPAIGNS / ("absolute/02" if known else "kr125") / "robot.toml"
    held = held_robot(tmp_path_factory.mktemp("clamped") / "kr125", robot)
    assert held.chain.masses_known == known
    return held


def readings(torque: Floats, joint: int, wrench: Floats | None = None) -> ClampedReadings:
    n = len(torque)
    torques = np.full((n, 6), np.nan)
    torques[:, joint - 1] = torque
    none = np.full((n, 6), np.nan)
    return ClampedReadings(
        (RunInfo("a", "clamped"),), np.zeros(n, dtype=np.int64), np.arange(n, dtype=np.float64), np.tile(POSE, (n, 1)),
        none if wrench is None else wrench, torques, np.array([False]),
    )  # fmt: skip


@pytest.mark.parametrize("joint", range(1, 7))
def test_the_robot_rests_under_it(campaign: Campaign, joint: int) -> None:
    """τ = g(q) − Jᵀ W by Newton-Euler: the moved drive carries what its motor gave, all others their weight alone."""
    chain = campaign.chain
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    found = held_wrench(campaign, readings(TORQUE, joint), campaign.manifest.runs[0], joint)
    assert found is not None
    model = pinocchio_model(chain)
    data = model.createData()
    angles = chain.model_angles(POSE[None])[0]
    weight = chain.drive_axes.T @ gravity_torques(model, angles)
    assert (np.abs(weight).max() > 100.0) == chain.masses_known
    assert setup.wrench_axes.body == setup.wrench_point.body == chain.n_joints + 1
    # moments are about the point's origin, in the sensor's axes
    last_from_point = pin.SE3(chain.flange) * pin.SE3(setup.wrench_point.transform)
    turn = setup.wrench_point.transform[:3, :3].T @ setup.wrench_axes.transform[:3, :3]
    still = np.zeros(model.nv)
    for torque, wrench in zip(TORQUE, found, strict=True):
        forces = [pin.Force.Zero() for _ in range(model.njoints)]
        at_point = pin.Force(np.concatenate([turn @ wrench[:3], turn @ wrench[3:]]))
        forces[model.njoints - 1] = last_from_point.act(at_point)
        drives = chain.drive_axes.T @ pin.rnea(model, data, angles, still, still, forces)
        wanted = weight.copy()
        wanted[joint - 1] = torque
        np.testing.assert_allclose(
            drives, wanted, rtol=0.0, atol=1e-8 * max(np.abs(weight).max(), np.abs(TORQUE).max())
        )


def test_a_sensors_reading_counts_as_it_is(campaign: Campaign) -> None:
    wrench = np.arange(30.0).reshape(5, 6)
    found = held_wrench(campaign, readings(TORQUE, 2, wrench), campaign.manifest.runs[0], 2)
    assert found is not None
    np.testing.assert_array_equal(found, wrench)


def test_nothing_is_known_without_sensor_and_torque(campaign: Campaign) -> None:
    assert held_wrench(campaign, readings(np.full(5, np.nan), 2), campaign.manifest.runs[0], 2) is None
