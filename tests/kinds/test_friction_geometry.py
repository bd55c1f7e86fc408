"""Friction in motion of which weight and inertia are modelled: a robot file without geometry is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.robot_checks import weight_faults
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.kinds.friction.fitting.torque_rows import motion_rows
from stiffcal.kinds.friction.logs.free_motion import free_motion
from stiffcal.measurements.load_states import RunInfo
from stiffcal.mechanics.rigid_body import rigid_torque
from stiffcal.model.balance.stated_spring import spring_torque
from tests.laboratory.robots import six_axes

MANIFEST = """schema = "stiffcal/campaign/1"
robot = "robot.toml"
[sources.drives]
time = { column = "t", unit = "s" }
joints = { position = "A1..A2", torque = "T1..T2", units = { position = "deg", torque = "N*m" } }
[[runs]]
id = "quick"
experiment = "friction"
files = { drives = "raw/drives.csv" }
"""
MODEL = """schema = "stiffcal/model/1"
[[effects]]
type = "joint-friction"
joints = "all"
"""


def robot_text(rows: str, joints: int = 2, head: str = "") -> str:
    entries = "".join(f'[[joints]]\nname = "A{k + 1}"\n{rows}' for k in range(joints))
    return f'schema = "stiffcal/robot/1"\nconvention = "modified-dh"\n{head}{entries}'


def swinging(time: Floats) -> Floats:
    """Return (n, 2) angles, deg, of two joints that move at the same time."""
    return np.stack([50.0 * np.sin(1.3 * time), 40.0 * np.sin(0.9 * time + 1.0)], axis=1)


def to_and_fro(time: Floats) -> Floats:
    """Return (n, 2) angles, deg, of joint 2 that goes to and fro at constant velocity."""
    passes = 40.0 * (1.0 - np.abs(np.mod(time / 2.5, 2.0) - 1.0))
    return np.stack([np.zeros_like(time), passes], axis=1)


def campaign(folder: Path, rows: str, motion: Callable[[Floats], Floats] = swinging) -> Path:
    """Write a run of two joints."""
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(MANIFEST)
    (folder / "model.toml").write_text(MODEL)
    (folder / "robot.toml").write_text(robot_text(rows))
    time = np.arange(0.0, 20.0, 0.01)
    angle = motion(time)
    torque = 10.0 * np.sign(np.gradient(angle, axis=0)) + 30.0 * np.cos(np.radians(angle))
    rows_of = np.column_stack([time, angle, torque])
    lines = ["t,A1,A2,T1,T2", *(",".join(f"{value:.5f}" for value in row) for row in rows_of)]
    (folder / "raw" / "drives.csv").write_text("\n".join(lines) + "\n")
    return folder


@pytest.mark.parametrize("motion", [swinging, to_and_fro])
def test_rows_of_zeros_are_refused_while_weight_is_modelled(tmp_path: Path, motion: Callable[[Floats], Floats]) -> None:
    with pytest.raises(InputError) as caught:
        check_campaign(campaign(tmp_path / "zeros", "a_m = 0\nalpha_deg = 0\nd_m = 0\n", motion))
    (fault,) = caught.value.faults
    assert (fault.code, fault.file, fault.place) == (FaultCode.VALUE_INVALID, "robot.toml", "joints")
    assert "quick" in fault.reason
    check_campaign(campaign(tmp_path / "filled", "a_m = 0.3\nalpha_deg = 90\n", motion))


@pytest.mark.parametrize(
    ("text", "refused", "refused_where_steady"),
    [
        (robot_text(""), True, True),
        (robot_text("", head="gravity_mps2 = [0, 0, 0]\n"), True, False),  # inertia of two axes in one
        (robot_text("", 1), True, False),  # upright, or not filled in?
        (robot_text("", 1, "gravity_mps2 = [0, 0, 0]\n"), False, False),
        (robot_text("", 1, "base = { rpy_deg = [90, 0, 0] }\n"), False, False),
        (robot_text("d_m = 0.3\n"), False, False),
    ],
)
def test_a_single_axis_needs_no_row_where_no_weight_acts(text: str, refused: bool, refused_where_steady: bool) -> None:
    import tomllib

    robot = RobotFile.model_validate(tomllib.loads(text))
    assert bool(weight_faults(robot, "robot.toml", "quick")) is refused
    assert bool(weight_faults(robot, "robot.toml", "quick", steady=True)) is refused_where_steady


def test_a_stated_balancing_spring_is_taken_out_of_the_motors_torque() -> None:
    """What the motor makes less friction, weight and inertia is nothing, with the spring in parallel with joint 2."""
    spring: dict[str, object] = {
        "joint": 2, "anchor_m": [-0.4, 0.0, -0.2], "arm_m": [0.3, 0.05, 0.0], "rate_N_m": 2e5, "preload_N": 5e3,
    }  # fmt: skip
    chain = replace(six_axes(), compensator=spring)
    time = np.arange(0.0, 20.0, 0.01)
    rng = np.random.default_rng(1)
    logged = np.stack([0.4 * np.sin(rate * time + phase) for rate, phase in rng.uniform(0.5, 1.5, (6, 2))], axis=1)
    angles = chain.model_angles(logged)
    velocity = np.gradient(angles, time, axis=0)
    held = rigid_torque(chain, angles, velocity, np.gradient(velocity, time, axis=0))
    alone = free_motion(RunInfo("quick", "friction"), chain, time, logged, held)
    balanced = free_motion(RunInfo("quick", "friction"), chain, time, logged, held - spring_torque(chain, angles))
    largest = float(np.abs(held).max())
    assert np.abs(spring_torque(chain, angles)).max() > 0.2 * largest
    by_weight = motion_rows(alone, replace(chain, compensator=None)).torque
    np.testing.assert_allclose(motion_rows(balanced, chain).torque, by_weight, atol=1e-3 * largest)
