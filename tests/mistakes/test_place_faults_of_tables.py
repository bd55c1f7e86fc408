"""Whole tables of absolute places with one mistake each: refused in one line that names it."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reading.reducing import reduce_campaign
from tests.laboratory.changed_tables import (
    CAMPAIGNS,
    PLACE,
    Reduce,
    Table,
    all_of,
    columns,
    exchanged,
    fault_of,
    scaled,
)


@pytest.mark.parametrize(("campaign", "n_joints"), [("01", 6), ("05", 7)])
def test_a_wrong_sign_is_named_by_its_joint(reduced: Reduce, tmp_path: Path, campaign: str, n_joints: int) -> None:
    for joint in range(1, n_joints + 1):
        fault = fault_of(reduced, campaign, scaled(f"A{joint}", -1.0))
        assert (fault.code, fault.place) == (FaultCode.KINEMATICS_MISMATCH, f"joint A{joint}")
        assert fault.changes == (InputChange("direction", (f"A{joint}",)),)
        shutil.rmtree(tmp_path / campaign)


@pytest.mark.parametrize(("campaign", "n_joints"), [("01", 6), ("05", 7)])
def test_a_zero_that_is_off_is_named_by_its_joint(
    reduced: Reduce, tmp_path: Path, campaign: str, n_joints: int
) -> None:
    for joint in range(2, n_joints):
        for sign in (1.0, -1.0):

            def off(table: Table, joint: int = joint, sign: float = sign) -> None:
                table[f"A{joint}"] = [value + sign * 90.0 for value in table[f"A{joint}"]]

            fault = fault_of(reduced, campaign, off)
            assert fault.place == f"joint A{joint}"
            # what has to be added to the logged angle
            assert fault.changes == (InputChange("zero", (f"A{joint}",), (-sign * np.pi / 2,)),)
            shutil.rmtree(tmp_path / campaign)


@pytest.mark.parametrize("joint", [1, 6])
def test_the_first_and_the_last_zero_are_the_frames(reduced: Reduce, joint: int) -> None:
    def off(table: Table) -> None:
        table[f"A{joint}"] = [value + 90.0 for value in table[f"A{joint}"]]

    assert reduced("01", off).result.n_states == 80


def test_a_whole_table_in_another_unit_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, 1e-3) for axis in PLACE)))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, "units.position")


def test_all_angles_in_another_unit_are_named(reduced: Reduce) -> None:
    """With such small angles all places seem to lie near one point: a smaller unit of length would fit as well."""
    fault = fault_of(reduced, "01", all_of(*(scaled(f"A{k}", np.pi / 180.0) for k in range(1, 7))))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, "joints.units.position")
    assert fault.changes == (InputChange("angle-unit", value="rad"),)


def test_a_target_that_no_pose_shows_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", all_of(*(scaled(f"{axis}2", np.nan) for axis in "XYZ")))
    assert (fault.code, fault.names) == (FaultCode.POSES_TOO_FEW, ("target2",))


def test_a_target_that_few_poses_show_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", all_of(*(scaled(f"{axis}2", np.nan, slice(3, None)) for axis in "XYZ")))
    assert (fault.code, fault.names) == (FaultCode.POSES_TOO_FEW, ("target2",))


def test_exchanged_columns_of_targets_are_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", lambda table: exchanged(table, slice(None)))
    assert fault.place == "poses.target1"
    assert fault.changes == (InputChange("target-order", ("target1", "target2")),)


def test_poses_too_alike_do_not_determine_the_frames(reduced: Reduce) -> None:
    def alike(table: Table) -> None:
        rng = np.random.default_rng(1)
        for joint in range(1, 7):
            table[f"A{joint}"] = (table[f"A{joint}"][0] + 0.3 * rng.normal(size=len(table["t"]))).tolist()
        for axis in PLACE:
            table[axis] = (table[axis][0] + rng.normal(size=len(table["t"]))).tolist()

    fault = fault_of(reduced, "01", alike)
    assert (fault.code, fault.names) == (FaultCode.POSES_TOO_FEW, ())


@pytest.mark.parametrize("rows", [1, -2])
def test_places_in_other_rows_than_their_angles_are_one_line(reduced: Reduce, rows: int) -> None:
    def moved(table: Table) -> None:
        for axis in PLACE:
            table[axis] = np.roll(table[axis], -rows).tolist()

    fault = fault_of(reduced, "01", moved)
    assert (fault.code, fault.place) == (FaultCode.KINEMATICS_MISMATCH, "the order of the rows")
    assert fault.changes == (InputChange("row-order", ("positions",), (float(rows),)),)


def test_one_target_in_another_unit_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", all_of(*(scaled(f"{axis}2", 1e-3) for axis in "XYZ")))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, "poses.target2.units.position")


def test_interchanged_columns_are_named(reduced: Reduce, tmp_path: Path) -> None:
    fault = fault_of(reduced, "01", columns("A2", "A3"))
    assert (fault.file, fault.place) == ("raw/poses.csv", "joints A2 and A3")
    shutil.rmtree(tmp_path / "01")
    # of the axes of positions in an estimated frame each interchange is the same mirror
    fault = fault_of(reduced, "01", columns("X1", "Y1"))
    assert fault.place == "columns of the positions"
    assert fault.changes == (InputChange("mirrored"),)
    shutil.rmtree(tmp_path / "01")
    fault = fault_of(reduced, "01", columns("X1", "Y1", slice(0, 40)))
    # where X and Y are alike nothing shows
    assert fault.changes == (InputChange("position-axes", ("Y", "X", "Z")),)
    assert len(fault.rows) == 37
    assert set(fault.rows) < set(range(1, 41))


@pytest.mark.parametrize(
    ("entry", "place"),
    [("a_m", "joints[3] (A3).a_m"), ("d_m", "joints[4] (A4).d_m"), ("convention", "convention")],
)
def test_a_wrong_sign_in_the_robot_file_is_named(tmp_path: Path, entry: str, place: str) -> None:
    folder = Path(shutil.copytree(CAMPAIGNS / "01", tmp_path / "01", ignore=shutil.ignore_patterns("store")))
    campaign = load_campaign(folder)
    if entry == "convention":
        robot = campaign.robot.model_copy(update={"convention": "dh"})
    else:
        k = int(place[7]) - 1
        joint = campaign.robot.joints[k]
        assert getattr(joint, entry) != 0.0
        wrong = joint.model_copy(update={entry: -getattr(joint, entry)})
        joints = (*campaign.robot.joints[:k], wrong, *campaign.robot.joints[k + 1 :])
        robot = campaign.robot.model_copy(update={"joints": joints})
    with pytest.raises(InputError) as refused:
        reduce_campaign(replace(campaign, robot=robot), no_progress)
    (fault,) = refused.value.faults
    assert (fault.file, fault.place) == ("robot.toml", place)


def test_a_robot_file_without_geometry_is_named(tmp_path: Path) -> None:
    """As `init` writes it without a robot: rows of zeros to fill in."""
    folder = Path(shutil.copytree(CAMPAIGNS / "01", tmp_path / "01", ignore=shutil.ignore_patterns("store")))
    campaign = load_campaign(folder)
    zeros = {"a_m": 0.0, "alpha_deg": 0.0, "d_m": 0.0}
    joints = tuple(joint.model_copy(update=zeros) for joint in campaign.robot.joints)
    with pytest.raises(InputError) as refused:
        reduce_campaign(replace(campaign, robot=campaign.robot.model_copy(update={"joints": joints})), no_progress)
    (fault,) = refused.value.faults
    assert (fault.code, fault.file, fault.place) == (FaultCode.VALUE_INVALID, "robot.toml", "joints")


def test_shuffled_places_contradict_the_angles(reduced: Reduce) -> None:
    def shuffled(table: Table) -> None:
        order = np.random.default_rng(1).permutation(len(table["t"]))
        for axis in PLACE:
            table[axis] = np.array(table[axis])[order].tolist()

    fault = fault_of(reduced, "01", shuffled)
    assert (fault.code, fault.file) == (FaultCode.KINEMATICS_MISMATCH, "raw/poses.csv")
    assert (fault.rows, fault.changes) == ((), ())


def test_targets_with_the_same_columns_are_named(reduced: Reduce) -> None:
    def copied(table: Table) -> None:
        for axis in "XYZ":
            table[f"{axis}2"] = list(table[f"{axis}1"])

    fault = fault_of(reduced, "03", copied)
    assert fault.place == "columns of target1 and target2"


def test_a_table_that_was_appended_twice_is_one_warning(reduced: Reduce) -> None:
    def twice(table: Table) -> None:
        for column in table:
            later = 1e5 if column == "t" else 0.0
            table[column] = table[column] + [value + later for value in table[column]]

    (warning,) = [text for text in reduced("01", twice).result.warnings if "repeat" in text]
    assert "run poses rows 81 to 160 repeat run poses rows 1 to 80:" in warning


@pytest.mark.parametrize(("column", "rows"), [("q0", slice(0, 40)), ("qx", slice(None))])
def test_orientations_that_contradict_the_angles_are_named(reduced: Reduce, column: str, rows: slice) -> None:
    """Signs of part of a quaternion that are wrong: positions fit, orientations do not."""
    fault = fault_of(reduced, "05", scaled(column, -1.0, rows))
    assert (fault.code, fault.file) == (FaultCode.KINEMATICS_MISMATCH, "raw/poses.csv")
    assert fault.place == "measured orientations"
