"""Tables of absolute places with one mistake each: refused in one line that names it, and nothing is identified."""

from __future__ import annotations

import csv
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import Fault, InputError, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reducing import ReducedCampaign, reduce_campaign
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.reduction.consistency import match_kinematics
from stiffcal.reduction.met_places import WORST_M

CAMPAIGNS = Path(__file__).parents[2] / "campaigns" / "absolute"
Table = dict[str, list[float]]
ROW = 20
# the header is the first line
AT_ROW = f"run poses, row {ROW + 1} (line {ROW + 2})"
PLACE = ("X1", "Y1", "Z1")
Reduce = Callable[[str, Callable[[Table], None]], ReducedCampaign]


@pytest.fixture
def reduced(tmp_path: Path) -> Reduce:
    """Return what is made of a bundled campaign whose table was changed."""

    def reduce(name: str, change: Callable[[Table], None]) -> ReducedCampaign:
        folder = Path(shutil.copytree(CAMPAIGNS / name, tmp_path / name, ignore=shutil.ignore_patterns("store")))
        file = folder / "raw" / "poses.csv"
        with file.open(encoding="utf-8") as lines:
            head, *rows = csv.reader(lines)
        table = {column: [float(row[k]) for row in rows] for k, column in enumerate(head)}
        change(table)
        text = [
            ["" if np.isnan(value) else f"{value:.9g}" for value in row] for row in zip(*table.values(), strict=True)
        ]
        file.write_text("\n".join(",".join(row) for row in [list(table), *text]) + "\n", encoding="utf-8")
        return reduce_campaign(load_campaign(folder), no_progress)

    return reduce


def fault_of(reduced: Reduce, name: str, change: Callable[[Table], None]) -> Fault:
    """Return the one fault."""
    with pytest.raises(InputError) as refused:
        reduced(name, change)
    (fault,) = refused.value.faults
    assert "\n" not in fault.reason + fault.mend
    return fault


def scaled(column: str, factor: float, rows: slice = slice(None)) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        values = np.array(table[column])
        values[rows] *= factor
        table[column] = values.tolist()

    return change


def all_of(*changes: Callable[[Table], None]) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        for each in changes:
            each(table)

    return change


def exchanged(table: Table, rows: slice) -> None:
    for axis in "XYZ":
        first, second = np.array(table[f"{axis}1"]), np.array(table[f"{axis}2"])
        first[rows], second[rows] = second[rows].copy(), first[rows].copy()
        table[f"{axis}1"], table[f"{axis}2"] = first.tolist(), second.tolist()


@pytest.mark.parametrize(("campaign", "n_joints"), [("01", 6), ("05", 7)])
def test_a_wrong_sign_is_named_by_its_joint(reduced: Reduce, tmp_path: Path, campaign: str, n_joints: int) -> None:
    for joint in range(1, n_joints + 1):
        fault = fault_of(reduced, campaign, scaled(f"A{joint}", -1.0))
        assert (fault.code, fault.place) == (FaultCode.KINEMATICS_MISMATCH, f"joint A{joint}")
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
            assert f"{'−' if sign > 0.0 else ''}90°" in fault.mend
            shutil.rmtree(tmp_path / campaign)


@pytest.mark.parametrize("joint", [1, 6])
def test_the_first_and_the_last_zero_are_the_frames(reduced: Reduce, joint: int) -> None:
    def off(table: Table) -> None:
        table[f"A{joint}"] = [value + 90.0 for value in table[f"A{joint}"]]

    assert reduced("01", off).result.n_states == 80


@pytest.mark.parametrize(("factor", "words"), [(1e-3, "a thousand times too small"), (1.0 / 25.4, "in inches")])
def test_a_row_in_another_unit_is_named(reduced: Reduce, factor: float, words: str) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, factor, slice(ROW, ROW + 1)) for axis in PLACE)))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, AT_ROW)
    assert fault.file == "raw/poses.csv"
    assert words in fault.reason


def test_a_whole_table_in_another_unit_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, 1e-3) for axis in PLACE)))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, "units.position")


def test_all_angles_in_another_unit_are_named(reduced: Reduce) -> None:
    """With such small angles all places seem to lie near one point: a smaller unit of length would fit as well."""
    fault = fault_of(reduced, "01", all_of(*(scaled(f"A{k}", np.pi / 180.0) for k in range(1, 7))))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, "joints.units.position")
    assert "radians" in fault.mend


def test_a_target_that_no_pose_shows_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", all_of(*(scaled(f"{axis}2", np.nan) for axis in "XYZ")))
    assert fault.code is FaultCode.POSES_TOO_FEW
    assert fault.reason == "target2 was measured in no unloaded pose"


def test_a_target_that_few_poses_show_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", all_of(*(scaled(f"{axis}2", np.nan, slice(3, None)) for axis in "XYZ")))
    assert fault.code is FaultCode.POSES_TOO_FEW
    assert fault.reason == "3 different unloaded poses are too few: target2 was measured in no others"


def test_angles_of_a_row_in_radians_are_named(reduced: Reduce) -> None:
    change = all_of(*(scaled(f"A{k}", np.pi / 180.0, slice(ROW, ROW + 1)) for k in range(1, 7)))
    fault = fault_of(reduced, "01", change)
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, AT_ROW)
    assert fault.file == "raw/poses.csv"


def test_exchanged_targets_of_a_row_are_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", lambda table: exchanged(table, slice(ROW, ROW + 1)))
    assert fault.place == AT_ROW
    assert "target1 and target2" in fault.reason


def test_exchanged_columns_of_targets_are_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", lambda table: exchanged(table, slice(None)))
    assert fault.place == "poses.target1"
    assert "target1 and target2" in fault.reason


def test_angles_of_another_row_are_named(reduced: Reduce) -> None:
    def copied(table: Table) -> None:
        for joint in range(1, 7):
            table[f"A{joint}"][ROW + 1] = table[f"A{joint}"][ROW]

    fault = fault_of(reduced, "01", copied)
    assert fault.place == f"run poses, row {ROW + 2} (line {ROW + 3})"
    assert f"exactly the joint angles of row {ROW + 1}" in fault.reason


def test_rows_of_one_mistake_are_one_line(reduced: Reduce) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, 1e-3, slice(ROW, ROW + 7)) for axis in PLACE)))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, f"{AT_ROW} and others")
    assert "in 7 of 80 rows (21 to 27)" in fault.reason


def test_more_mistakes_than_are_listed_are_counted(reduced: Reduce) -> None:
    factors = (1e-3, 1e-2, 1e-1, 1.0 / 25.4)
    units = [scaled(axis, f, slice(k, k + 1)) for k, f in enumerate(factors) for axis in PLACE]
    with pytest.raises(InputError) as refused:
        reduced("01", all_of(*units, scaled("A2", -1.0, slice(5, 6)), scaled("A3", -1.0, slice(6, 7))))
    assert [fault.code for fault in refused.value.faults] == [FaultCode.UNIT_IMPLAUSIBLE] * 4 + [FaultCode.MORE_FAULTS]
    assert refused.value.faults[-1].reason.startswith("2 ")


def test_a_pose_in_which_no_target_was_measured_is_set_aside_by_its_row(reduced: Reduce) -> None:
    made = reduced("01", all_of(*(scaled(axis, np.nan, slice(ROW, ROW + 1)) for axis in PLACE)))
    (warning,) = [text for text in made.result.warnings if "no target" in text]
    assert f"row {ROW + 1} " in warning
    states = made.states
    (chosen,) = np.flatnonzero(~states.used)
    assert int(states.row[chosen]) == ROW + 1
    assert states.set_aside_code[chosen] == SetAsideCode.NOT_MEASURED.value


def test_a_copied_row_is_a_warning(reduced: Reduce) -> None:
    def copied(table: Table) -> None:
        for column in table:
            if column != "t":
                table[column][ROW + 1] = table[column][ROW]

    (warning,) = [text for text in reduced("01", copied).result.warnings if "repeat" in text]
    assert f"run poses row {ROW + 2} repeats run poses row {ROW + 1}" in warning


def test_poses_too_alike_do_not_determine_the_frames(reduced: Reduce) -> None:
    def alike(table: Table) -> None:
        rng = np.random.default_rng(1)
        for joint in range(1, 7):
            table[f"A{joint}"] = (table[f"A{joint}"][0] + 0.3 * rng.normal(size=len(table["t"]))).tolist()
        for axis in PLACE:
            table[axis] = (table[axis][0] + rng.normal(size=len(table["t"]))).tolist()

    fault = fault_of(reduced, "01", alike)
    assert fault.code is FaultCode.POSES_TOO_FEW
    assert "3 different unloaded poses are too few" in fault.reason


@pytest.mark.parametrize(("rows", "words"), [(1, "down by one row"), (-2, "up by 2 rows")])
def test_places_in_other_rows_than_their_angles_are_one_line(reduced: Reduce, rows: int, words: str) -> None:
    def moved(table: Table) -> None:
        for axis in PLACE:
            table[axis] = np.roll(table[axis], -rows).tolist()

    fault = fault_of(reduced, "01", moved)
    assert (fault.code, fault.place) == (FaultCode.KINEMATICS_MISMATCH, "the order of the rows")
    assert f"move the columns of the places {words}" in fault.mend


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (slice(40, 80), "40 of 80 rows (41 to 80)"),
        (slice(None, None, 2), "40 of 80 rows (1, 3, 5, 7, 9, 11 and 34 more places)"),
        (slice(20, 80), "60 of 80 rows (21 to 80)"),
        (slice(20, 30), "10 of 80 rows (21 to 30)"),
    ],
)
def test_exchanged_targets_of_many_rows_are_one_line(reduced: Reduce, rows: slice, words: str) -> None:
    """Where the manifest states the targets' places on the body, those at another's place are named."""
    fault = fault_of(reduced, "03", lambda table: exchanged(table, rows))
    assert fault.code is FaultCode.KINEMATICS_MISMATCH
    assert fault.reason == f"the positions of target1 and target2 are interchanged in {words}"


def test_two_rows_of_two_mistakes_are_two_lines(reduced: Reduce) -> None:
    in_metres = all_of(*(scaled(axis, 1e-3, slice(ROW + 5, ROW + 6)) for axis in PLACE))
    with pytest.raises(InputError) as refused:
        reduced("03", all_of(lambda table: exchanged(table, slice(ROW, ROW + 1)), in_metres))
    first, second = refused.value.faults
    assert (first.code, first.place) == (FaultCode.KINEMATICS_MISMATCH, AT_ROW)
    assert (second.code, second.place) == (FaultCode.UNIT_IMPLAUSIBLE, f"run poses, row {ROW + 6} (line {ROW + 7})")


def test_targets_exchanged_in_a_circle_are_named(reduced: Reduce) -> None:
    def circle(table: Table) -> None:
        for axis in "XYZ":
            columns = [np.array(table[f"{axis}{k}"]) for k in (1, 2, 3)]
            for k, column in enumerate(columns):
                table[f"{axis}{(k + 1) % 3 + 1}"][40:] = column[40:].tolist()

    fault = fault_of(reduced, "03", circle)
    assert "target1, target2 and target3 are interchanged in 40 of 80 rows (41 to 80)" in fault.reason


@pytest.mark.parametrize(("factor", "words"), [(1e-3, "a thousand times too small"), (1.0 / 25.4, "in inches")])
def test_one_target_of_a_row_in_another_unit_is_named(reduced: Reduce, factor: float, words: str) -> None:
    change = all_of(*(scaled(f"{axis}2", factor, slice(ROW, ROW + 1)) for axis in "XYZ"))
    fault = fault_of(reduced, "03", change)
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, AT_ROW)
    assert fault.file == "raw/poses.csv"
    assert f"the positions of target2 are {words}" in fault.reason


def test_one_target_in_another_unit_is_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", all_of(*(scaled(f"{axis}2", 1e-3) for axis in "XYZ")))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, "poses.target2.units.position")


@pytest.mark.parametrize(
    ("rows", "factor", "words"),
    [
        (slice(40, 80), 1e-3, "a thousand times too small in 40 of 80 rows (41 to 80)"),
        (slice(20, 80), 1.0 / 25.4, "in inches where the others are in millimetres in 60 of 80 rows (21 to 80)"),
    ],
)
def test_many_rows_in_another_unit_are_one_line(reduced: Reduce, rows: slice, factor: float, words: str) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, factor, rows) for axis in PLACE)))
    assert fault.code is FaultCode.UNIT_IMPLAUSIBLE
    assert fault.reason == f"the positions are {words}"


HALVES = [(slice(0, 40), "(1 to 40)"), (slice(1, None, 2), "(2, 4, 6, 8, 10, 12 and 34 more places)")]


@pytest.mark.parametrize(("joint", "rows", "where"), [(1, *HALVES[0]), (3, *HALVES[1]), (5, *HALVES[0])])
def test_a_wrong_sign_in_half_of_the_rows_is_one_line(reduced: Reduce, joint: int, rows: slice, where: str) -> None:
    fault = fault_of(reduced, "01", scaled(f"A{joint}", -1.0, rows))
    assert fault.code is FaultCode.KINEMATICS_MISMATCH
    assert fault.reason.startswith(f"the angle of joint A{joint} has the wrong sign in ")
    # small angles of joint 5 are right within millimetres with either sign
    assert joint == 5 or f" in 40 of 80 rows {where}" in fault.reason
    assert fault.file == "raw/poses.csv"


@pytest.mark.parametrize(("rows", "where"), HALVES)
def test_radians_in_half_of_the_rows_are_one_line(reduced: Reduce, rows: slice, where: str) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(f"A{k}", np.pi / 180.0, rows) for k in range(1, 7))))
    assert fault.code is FaultCode.UNIT_IMPLAUSIBLE
    assert fault.reason == f"joint angles are in radians where the others are in degrees in 40 of 80 rows {where}"


def test_excluded_rows_do_not_count_in_the_check_of_the_kinematics(tmp_path: Path) -> None:
    """Frames are found from the rows in use; half of the rows, wrong and excluded, are not compared with them."""
    folder = Path(shutil.copytree(CAMPAIGNS / "01", tmp_path / "01", ignore=shutil.ignore_patterns("store")))
    file = folder / "raw" / "poses.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    assert len(rows) == 80
    angles = [k for k, column in enumerate(head.split(",")) if column in {f"A{joint}" for joint in range(1, 7)}]
    for n in range(40, 80):
        cells = rows[n].split(",")
        for k in angles:
            cells[k] = f"{np.radians(float(cells[k])):.9g}"
        rows[n] = ",".join(cells)
    file.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    source = next(iter(load_campaign(folder).manifest.sources))
    with (folder / "campaign.toml").open("a", encoding="utf-8") as manifest:
        manifest.write(f'\n[[exclude]]\nsource = "{source}"\nrows = ["41-80"]\nwhy = "radians"\n')
    campaign = load_campaign(folder)
    states = reduce_campaign(campaign, no_progress).states
    assert states.used.sum() == 40
    # an uncalibrated robot misses by millimetres in all rows that are used
    assert match_kinematics(states, campaign.chain).worst_m < WORST_M


def test_rows_that_a_mistake_hardly_moves_are_named_with_the_others(reduced: Reduce) -> None:
    """Angles near zero are right within the limit in either unit: nobody can say which of these rows are wrong."""
    fault = fault_of(reduced, "01", scaled("A4", np.pi / 180.0, slice(40, 80)))
    wrong, perhaps = (rows_in(text) for text in fault.reason.split(", and perhaps in "))
    assert wrong < set(range(41, 81))
    assert set(range(41, 81)) <= wrong | perhaps
    assert rows_in(fault.mend.split("[[exclude]] rows = ")[1].replace('"', "").replace("-", " to ")) == wrong


def rows_in(text: str) -> set[int]:
    """Return the rows of the list that a line has in brackets, or else after its first word."""
    stretches = re.findall(r"(\d+)(?: to (\d+))?(?=[,)\]])", text[text.rfind("(") + 1 :])
    return {row for first, last in stretches for row in range(int(first), int(last or first) + 1)}


def columns(first: str, second: str, rows: slice = slice(None)) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        one, other = np.array(table[first]), np.array(table[second])
        one[rows], other[rows] = other[rows].copy(), one[rows].copy()
        table[first], table[second] = one.tolist(), other.tolist()

    return change


def test_interchanged_columns_are_named(reduced: Reduce, tmp_path: Path) -> None:
    fault = fault_of(reduced, "01", columns("A2", "A3"))
    assert (fault.file, fault.place) == ("raw/poses.csv", "joints A2 and A3")
    shutil.rmtree(tmp_path / "01")
    # of the axes of positions in an estimated frame each interchange is the same mirror
    fault = fault_of(reduced, "01", columns("X1", "Y1"))
    assert fault.place == "columns of the positions"
    assert "mirrored" in fault.reason
    shutil.rmtree(tmp_path / "01")
    fault = fault_of(reduced, "01", columns("X1", "Y1", slice(0, 40)))
    # where X and Y are alike nothing shows
    assert fault.reason.startswith("X and Y of the positions are interchanged in 37 of 80 rows (1 to 9, ")


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
    assert "holds no geometry" in fault.reason
    assert "--robot NAME" in fault.mend


def test_places_next_to_the_angles_of_other_rows_are_named(reduced: Reduce) -> None:
    def shifted(table: Table) -> None:
        for axis in PLACE:
            table[axis][40:] = [*table[axis][41:], table[axis][40]]

    fault = fault_of(reduced, "01", shifted)
    assert fault.place == "run poses, row 41 (line 42) and others"
    assert "of row 41 those of row 42" in fault.reason
    assert "in 40 of 80 rows (41 to 80)" in fault.reason


def test_shuffled_places_contradict_the_angles(reduced: Reduce) -> None:
    def shuffled(table: Table) -> None:
        order = np.random.default_rng(1).permutation(len(table["t"]))
        for axis in PLACE:
            table[axis] = np.array(table[axis])[order].tolist()

    fault = fault_of(reduced, "01", shuffled)
    assert (fault.code, fault.file) == (FaultCode.KINEMATICS_MISMATCH, "raw/poses.csv")
    assert "contradict" in fault.reason
    assert "each position is next to its joint angles" in fault.mend


def test_a_tracker_that_was_moved_far_is_named_by_its_rows(reduced: Reduce) -> None:
    def moved(table: Table) -> None:
        table["X1"] = [value + 50.0 * (k >= 40) for k, value in enumerate(table["X1"])]

    fault = fault_of(reduced, "01", moved)
    shift = float(fault.reason.split("tracker or base by ")[1].split(" mm")[0])
    # what the geometry of other poses takes up is less than a robot misses by
    assert abs(shift - 50.0) < 5.0
    assert "(41 to 80)" in fault.reason or "(1 to 40)" in fault.reason


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
    assert "w first" in fault.mend
