"""Angles counted in another way than stated are named: together, from another zero, in another direction or unit."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import Fault, InputError, no_progress
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.mistakes.catalogue.angles.counted_together import CountedTogether
from stiffcal.mistakes.inputs.mistake import AsRead, TriedOn
from stiffcal.mistakes.references.kinematics import check_kinematics
from tests.laboratory.displacement_table import (
    JOINTS,
    campaign_of_robot,
    displacement_columns,
    write_displacement_campaign,
    write_table,
)
from tests.laboratory.hidden_campaigns import folder_of, reduced
from tests.laboratory.robots import DEGREES, six_axes

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"
SIGNS = {1: "logged = { A2 = 1, A3 = 1 }", -1: "logged = { A2 = -1, A3 = 1 }"}


def test_every_joint_can_be_counted_together_with_one_before_it() -> None:
    pairs = {(f"A{first}", f"A{second}") for second in range(2, 7) for first in range(1, second)}
    read = AsRead.all_rows(TriedOn.REFERENCES, reduced("01").states, six_axes())
    assert {way.names for way in CountedTogether().ways(read)} == pairs


@pytest.mark.parametrize(("first", "second"), [(1, 2), (1, 3), (2, 4), (3, 5), (4, 5), (4, 6), (5, 6)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_axes_that_are_not_parallel_counted_together(first: int, second: int, sign: float, tmp_path: Path) -> None:
    """As the motors of a wrist are: neither another zero nor a missing effect."""
    columns = displacement_columns(12)
    columns[f"A{second}"] += sign * columns[f"A{first}"]
    fault = _place_named(write_displacement_campaign(tmp_path / "cell", columns))
    assert fault.place.endswith(f"joints A{first} and A{second}")


def _together(sign: int) -> InputChange:
    """Return what is named where A3 is counted together with A2."""
    return InputChange("counted-together", ("A2", "A3"), (float(sign),))


@pytest.mark.parametrize("rows", [8, 24])
@pytest.mark.parametrize("sign", SIGNS)
def test_in_a_table_of_displacements(sign: int, rows: int, tmp_path: Path) -> None:
    columns = displacement_columns(rows)
    columns["A3"] -= sign * columns["A2"]
    folder = write_displacement_campaign(tmp_path / "cell", columns)
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(folder), no_progress)
    (fault,) = refused.value.faults
    assert fault.code is FaultCode.KINEMATICS_MISMATCH
    assert fault.changes == (_together(sign),)
    # what is to be written there mends it
    robot = folder / "robot.toml"
    robot.write_text(robot.read_text().replace('name = "A3"', f'name = "A3"\n{SIGNS[sign]}'))
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == rows


def _faults_of(folder: Path) -> tuple[Fault, ...]:
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(folder), no_progress)
    return tuple(refused.value.faults)


def _place_named(folder: Path) -> Fault:
    (fault,) = _faults_of(folder)
    assert fault.code is FaultCode.KINEMATICS_MISMATCH
    return fault


@pytest.mark.parametrize(("robot", "stated"), [("r2000ic", 1.0), ("irb4400", -1.0)])
def test_a_table_that_counts_by_itself_what_the_robot_file_counts_together(
    robot: str, stated: float, tmp_path: Path
) -> None:
    folder, columns = campaign_of_robot(robot, 12, tmp_path / "cell")
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == 12
    columns["A3"] += stated * columns["A2"]
    write_table(folder / "raw" / "table.csv", columns)
    assert _place_named(folder).place.endswith("joints A2 and A3")


def test_what_the_robot_file_counts_together_is_removed_where_the_table_does_not(tmp_path: Path) -> None:
    folder, columns = campaign_of_robot("r2000ic", 12, tmp_path / "cell")
    columns["A3"] += columns["A2"]
    write_table(folder / "raw" / "table.csv", columns)
    assert _place_named(folder).changes == (_together(-1),)
    robot = folder / "robot.toml"
    robot.write_text(robot.read_text().replace("logged = { A2 = 1, A3 = 1 }\n", ""))
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == 12


@pytest.mark.parametrize("joint", ["A2", "A3", "A5"])
def test_the_sign_of_a_joint_is_named(joint: str, tmp_path: Path) -> None:
    columns = displacement_columns(12)
    columns[joint] = -columns[joint]
    fault = _place_named(write_displacement_campaign(tmp_path / "cell", columns))
    assert fault.place.endswith(f"joint {joint}")
    assert fault.changes == (InputChange("direction", (joint,)),)


@pytest.mark.parametrize("joint", ["A2", "A3", "A5"])
@pytest.mark.parametrize("off", [90.0, 10.0, -33.0])
def test_the_zero_of_a_joint_is_named_with_its_angle(joint: str, off: float, tmp_path: Path) -> None:
    columns = displacement_columns(12)
    columns[joint] += off
    fault = _place_named(write_displacement_campaign(tmp_path / "cell", columns))
    assert fault.place.endswith(f"joint {joint}")
    (change,) = fault.changes
    assert (change.kind, change.names) == ("zero", (joint,))
    assert np.degrees(change.sizes) == pytest.approx([-off], abs=0.5)


def test_a_zero_within_a_robots_own_inaccuracy_is_let_pass(tmp_path: Path) -> None:
    columns = displacement_columns(12)
    columns["A5"] += 3.0
    folder = write_displacement_campaign(tmp_path / "cell", columns)
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == 12


@pytest.mark.parametrize("robot", ["irb4400", "ur10e"])
def test_radians_called_degrees_are_named_where_springs_explain_much_of_either(robot: str, tmp_path: Path) -> None:
    folder, columns = campaign_of_robot(robot, 24, tmp_path / "cell")
    for name in JOINTS:
        columns[name] = np.radians(columns[name])
    write_table(folder / "raw" / "table.csv", columns, decimals=6)
    (fault,) = _faults_of(folder)
    assert fault.code is FaultCode.UNIT_IMPLAUSIBLE
    assert fault.place == "sources.table.joints.units.position"
    assert fault.changes == (InputChange("angle-unit", value="rad"),)


@pytest.mark.parametrize("rows", [8, 24])
def test_gon_called_degrees_are_named_and_no_zero_of_a_joint(rows: int, tmp_path: Path) -> None:
    columns = displacement_columns(rows)
    for name in JOINTS:
        columns[name] *= 400.0 / 360.0
    folder = write_displacement_campaign(tmp_path / "cell", columns)
    (fault,) = _faults_of(folder)
    assert fault.changes == (InputChange("angle-unit", value="gon"),)
    # what is to be written there mends it
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text().replace('position = "deg"', 'position = "gon"'))
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == rows


def test_gon_called_degrees_are_named_in_places_under_load() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    read = replace(states, joints=states.joints * 400.0 / 360.0)
    (fault,) = check_kinematics(read, chain, estimated=False, stated=DEGREES)
    assert fault.changes == (InputChange("angle-unit", value="gon"),)


@pytest.mark.parametrize("joint", ["A2", "A3", "A5"])
def test_one_joint_in_radians_is_named(joint: str, tmp_path: Path) -> None:
    columns = displacement_columns(12)
    columns[joint] = np.radians(columns[joint])
    (fault,) = _faults_of(write_displacement_campaign(tmp_path / "cell", columns))
    assert fault.changes == (InputChange("joint-unit", (joint,), value="rad"),)


@pytest.mark.parametrize("seed", range(3))
def test_what_the_model_lacks_is_no_other_way_to_count(seed: int, tmp_path: Path) -> None:
    columns = displacement_columns(8, seed)
    # a foundation that gives: as much as a quarter of what the springs do
    root = np.random.default_rng(seed).standard_normal((3, 3))
    force = np.stack([columns[name] for name in ("Fx", "Fy", "Fz")], axis=1)
    lacking = force @ root @ root.T
    largest = max(np.abs(columns[name]).max() for name in ("dx", "dy", "dz"))
    for k, name in enumerate(("dx", "dy", "dz")):
        columns[name] += 0.25 * largest * lacking[:, k] / np.abs(lacking).max()
    assert reduce_campaign(
        load_campaign(write_displacement_campaign(tmp_path / "cell", columns)), no_progress
    ).result.n_states == len(force)


def test_a_sound_table_is_let_pass(tmp_path: Path) -> None:
    folder = write_displacement_campaign(tmp_path / "cell", displacement_columns(8))
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == 8


@pytest.mark.parametrize("sign", SIGNS)
def test_in_places_under_load(sign: int) -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    joints = states.joints.copy()
    joints[:, 2] -= sign * joints[:, 1]
    (fault,) = check_kinematics(replace(states, joints=joints), chain, estimated=False, stated=DEGREES)
    assert fault.changes == (_together(sign),)


@pytest.mark.parametrize("sign", SIGNS)
def test_in_a_table_of_absolute_places(sign: int, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(CAMPAIGN, tmp_path / "cell"))
    table = folder / "raw" / "poses.csv"
    header, *rows = [line.split(",") for line in table.read_text().splitlines()]
    second, third = header.index("A2"), header.index("A3")
    for row in rows:
        row[third] = repr(float(row[third]) - sign * float(row[second]))
    table.write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n")
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(folder), no_progress)
    (fault,) = refused.value.faults
    assert fault.changes == (_together(sign),)


def test_half_a_turn_is_named_where_the_trackers_frame_is_estimated_as_well() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    joints = states.joints.copy()
    joints[:, 1] += np.pi
    (fault,) = check_kinematics(replace(states, joints=joints), chain, estimated=True, stated=DEGREES)
    assert (fault.changes[0].kind, fault.changes[0].names) == ("zero", ("A2",))
