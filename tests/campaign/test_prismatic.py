"""Robots with prismatic joints as a person writes them: what is refused, in one line each, and what init proposes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_checks import robot_faults
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.errors import InputError
from stiffcal.propose.from_table import propose_campaign
from stiffcal.reduction.logs.reading_bounds import first_impossible

ROWS: list[dict[str, Any]] = [
    {"name": "X1", "alpha_deg": 90.0, "theta_deg": 90.0, "type": "prismatic", "limits_m": [-1.0, 2.0]},
    {"name": "A1", "alpha_deg": -90.0, "d_m": 0.5},
    {"name": "A2", "a_m": 0.2, "alpha_deg": -90.0},
    {"name": "A3", "a_m": 0.9},
]
URDF = """<robot name="r"><link name="base"/><link name="c"/><link name="l1"/><link name="l2"/>
<joint name="rail" type="prismatic"><parent link="base"/><child link="c"/><axis xyz="0 1 0"/>{limit}</joint>
<joint name="pan_joint" type="revolute"><parent link="c"/><child link="l1"/><axis xyz="0 0 1"/></joint>
<joint name="lift_joint" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0 0 0.4"/><axis xyz="1 0 0"/>
</joint></robot>"""
LIMIT = '<limit lower="0" upper="3" effort="1" velocity="1"/>'


def robot_of(rows: list[dict[str, Any]], **more: Any) -> RobotFile:
    return RobotFile.model_validate({"schema": "stiffcal/robot/1", "convention": "modified-dh", "joints": rows, **more})


@pytest.mark.parametrize(
    ("joint", "change", "words"),
    [
        (0, {"limits_m": None}, "two ends, and none are given; add limits_m"),
        (0, {"limits_m": [2.0, -1.0]}, "the lower limit 2.0 is not below -1.0"),
        (0, {"limits_m": [0.0, 3000.0]}, "looks like mm: write 3"),
        (0, {"limits_deg": [-90, 90]}, "X1 is prismatic: it has no angle; write limits_m"),
        (0, {"gear_orders": [100]}, "X1 is prismatic: it has no angle; remove gear_orders"),
        (1, {"limits_m": [0.0, 1.0]}, "A1 is revolute"),
        (1, {"logged": {"A1": 1.0, "X1": 1.0}}, "an angle and a length have no sum"),
    ],
)
def test_what_contradicts_its_kind(joint: int, change: dict[str, Any], words: str) -> None:
    rows = [dict(row) for row in ROWS]
    rows[joint] = {key: value for key, value in (rows[joint] | change).items() if value is not None}
    (fault,) = robot_faults(robot_of(rows), "robot.toml")
    assert words in f"{fault.reason}; {fault.mend}"


def test_a_balancing_spring_needs_a_joint_that_turns() -> None:
    spring = {"joint": 1, "anchor_m": [0, 0, 0], "arm_m": [0.1, 0, 0]}
    (fault,) = robot_faults(robot_of(ROWS, gravity_compensator=spring), "robot.toml")
    assert "X1 is prismatic" in fault.reason


def test_limits_are_m_and_theta_is_a_fixed_turn(tmp_path: Path) -> None:
    chain = chain_of(robot_of(ROWS), tmp_path)
    assert chain.limits[0].tolist() == [-1.0, 2.0]
    assert chain.offset[0] == 0.0
    assert chain.prismatic.tolist() == [True, False, False, False]
    np.testing.assert_allclose(chain.printed_positions(np.array([0.5, np.pi, 0.0, 0.0])), [500.0, 180.0, 0.0, 0.0])
    np.testing.assert_allclose(chain.from_printed(np.array([500.0, 180.0, 0.0, 0.0])), [0.5, np.pi, 0.0, 0.0])
    # the link before a prismatic joint has no fixed length
    swapped = [ROWS[1], ROWS[2], ROWS[3], ROWS[0] | {"a_m": 0.4}]
    assert len(chain_of(robot_of(swapped), tmp_path).beams) == 2


def table(folder: Path, header: str, factor: float) -> Path:
    rng = np.random.default_rng(1)
    rows = [header]
    for _ in range(12):
        values = [factor * rng.uniform(0.0, 3.0), *rng.uniform(-90.0, 90.0, 2), *rng.uniform(-900.0, 900.0, 3)]
        rows.append(",".join(f"{value:.4f}" for value in values))
    (folder / "table.csv").write_text("\n".join(rows) + "\n")
    return folder / "table.csv"


@pytest.mark.parametrize(
    ("head", "factor", "unit"), [("rail [mm]", 1e3, "mm"), ("rail", 1e3, "mm"), ("rail [m]", 1.0, "m")]
)
def test_init_writes_a_unit_for_each_column(tmp_path: Path, head: str, factor: float, unit: str) -> None:
    (tmp_path / "cell.urdf").write_text(URDF.format(limit=LIMIT))
    path = table(tmp_path, f"{head},pan_joint,lift_joint,P1_x,P1_y,P1_z", factor)
    proposal = propose_campaign(tmp_path / "cell", [path], urdf=tmp_path / "cell.urdf")
    assert f'units = {{ position = ["{unit}", "deg", "deg"] }}' in proposal.manifest
    campaign = load_campaign(tmp_path / "cell")
    assert campaign.chain.prismatic_names == {"rail"}
    assert campaign.chain.limits[0].tolist() == [0.0, 3.0]


def test_without_limits_the_mend_names_the_urdf(tmp_path: Path) -> None:
    (tmp_path / "cell.urdf").write_text(URDF.format(limit=""))
    path = table(tmp_path, "rail,pan_joint,lift_joint,P1_x,P1_y,P1_z", 1e3)
    with pytest.raises(InputError, match=r"two ends, and none are given; add <limit .* in the URDF"):
        propose_campaign(tmp_path / "cell", [path], urdf=tmp_path / "cell.urdf")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('["mm", "deg", "deg"]', '"deg"', r"rail is prismatic, and its column is read in .deg.*\[.mm., .deg., .deg.\]"),
        ('["mm", "deg", "deg"]', '["mm", "mm", "deg"]', "pan_joint is revolute"),
        ('["mm", "deg", "deg"]', '["mm", "deg"]', "2 units for 3 joints"),
        ('"deg"] }', '"deg"] }, motor = true', "motor-side logs are turns"),
        ('experiment = "absolute"', 'experiment = "friction"', "friction runs measure torque over angle"),
    ],
)
def test_manifests_that_do_not_fit(tmp_path: Path, old: str, new: str, words: str) -> None:
    (tmp_path / "cell.urdf").write_text(URDF.format(limit=LIMIT))
    path = table(tmp_path, "rail,pan_joint,lift_joint,P1_x,P1_y,P1_z", 1e3)
    propose_campaign(tmp_path / "cell", [path], urdf=tmp_path / "cell.urdf")
    manifest = tmp_path / "cell" / "campaign.toml"
    text = manifest.read_text()
    assert old in text
    manifest.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=words):
        load_campaign(tmp_path / "cell")


def test_a_long_track_is_no_mistake_of_a_unit() -> None:
    rows = np.array([[15.0, 16.0], [0.1, 0.2]])
    bounds = rows.min(axis=1), rows.max(axis=1)
    assert first_impossible("joints", rows, *bounds, ("X1", "A1"), {"X1"}) is None
    wrong = first_impossible("joints", 1e3 * rows, *bounds, ("X1", "A1"), {"X1"})
    assert wrong is not None
    assert "15000 m in column X1" in wrong.reason.replace("1.5e+04", "15000")
    turned = first_impossible("joints", rows[::-1], *bounds, ("X1", "A1"), {"X1"})
    assert turned is not None
    assert "rad in column A1" in turned.reason


@pytest.mark.parametrize(
    ("angles", "mend"),
    [
        ("rad", 'degrees declared as radians? write units = { position = "deg" }; motor side? motor = true'),
        ("deg", "is this the column of another quantity? motor side? motor = true"),
    ],
)
def test_no_unit_is_proposed_that_the_column_has(angles: str, mend: str) -> None:
    """A position in the column of an angle is too large for one in whatever unit."""
    rows = np.array([[0.1, 0.2], [46.0, 47.0]])
    declared = {"X1": "mm", "A1": angles}
    bounds = rows.min(axis=1), rows.max(axis=1)
    wrong = first_impossible("joints", rows, *bounds, ("X1", "A1"), {"X1"}, declared)
    assert wrong is not None
    assert wrong.mend == mend
    rows = np.array([[1e3, 2e3], [0.1, 0.2]])
    far = first_impossible("joints", rows, *(rows[:, 0], rows[:, 1]), ("X1", "A1"), {"X1"}, declared)
    assert far is not None
    assert far.mend == "is this the column of another quantity?"
