"""Friction in motion of which weight and inertia are modelled: a robot file without geometry is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.robot_checks import weight_faults
from stiffcal.campaign.robot_file import RobotFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.workflow.check import check_campaign

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


def campaign(folder: Path, rows: str) -> Path:
    """Write two joints that swing at the same time."""
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(MANIFEST)
    (folder / "model.toml").write_text(MODEL)
    (folder / "robot.toml").write_text(robot_text(rows))
    time = np.arange(0.0, 20.0, 0.01)
    angle = np.stack([50.0 * np.sin(1.3 * time), 40.0 * np.sin(0.9 * time + 1.0)], axis=1)
    torque = 10.0 * np.sign(np.gradient(angle, axis=0)) + 30.0 * np.cos(np.radians(angle))
    rows_of = np.column_stack([time, angle, torque])
    lines = ["t,A1,A2,T1,T2", *(",".join(f"{value:.5f}" for value in row) for row in rows_of)]
    (folder / "raw" / "drives.csv").write_text("\n".join(lines) + "\n")
    return folder


def test_rows_of_zeros_are_refused_while_weight_is_modelled(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        check_campaign(campaign(tmp_path / "zeros", "a_m = 0\nalpha_deg = 0\nd_m = 0\n"))
    (fault,) = caught.value.faults
    assert (fault.code, fault.file, fault.place) == (FaultCode.VALUE_INVALID, "robot.toml", "joints")
    assert "quick" in fault.reason
    assert check_campaign(campaign(tmp_path / "filled", "a_m = 0.3\nalpha_deg = 90\n")).missing == []


@pytest.mark.parametrize(
    ("text", "refused"),
    [
        (robot_text(""), True),
        (robot_text("", head="gravity_mps2 = [0, 0, 0]\n"), True),  # inertia of two axes in one
        (robot_text("", 1), True),  # upright, or not filled in?
        (robot_text("", 1, "gravity_mps2 = [0, 0, 0]\n"), False),
        (robot_text("", 1, "base = { rpy_deg = [90, 0, 0] }\n"), False),
        (robot_text("d_m = 0.3\n"), False),
    ],
)
def test_a_single_axis_needs_no_row_where_no_weight_acts(text: str, refused: bool) -> None:
    import tomllib

    robot = RobotFile.model_validate(tomllib.loads(text))
    assert bool(weight_faults(robot, "robot.toml", "quick")) is refused
