"""Rows of absolute places with one mistake each: refused in one line that names it, and nothing is identified."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.mistakes.references.match import match_kinematics
from stiffcal.reduction.registration.registering import WORST_M
from tests.laboratory.changed_tables import (
    CAMPAIGNS,
    PLACE,
    Reduce,
    Table,
    all_of,
    exchanged,
    fault_of,
    scaled,
)

ROW = 20
# the header is the first line
AT_ROW = f"run poses, row {ROW + 1} (line {ROW + 2})"
EXCHANGED = InputChange("target-order", ("target1", "target2"))


def numbers(rows: slice) -> tuple[int, ...]:
    """Return the numbers of some of the table's 80 rows."""
    return tuple(range(1, 81)[rows])


@pytest.mark.parametrize("factor", [1e-3, 1.0 / 25.4])
def test_a_row_in_another_unit_is_named(reduced: Reduce, factor: float) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, factor, slice(ROW, ROW + 1)) for axis in PLACE)))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, AT_ROW)
    assert fault.file == "raw/poses.csv"
    assert fault.changes == (InputChange("length-factor", sizes=(1.0 / factor,)),)


def test_angles_of_a_row_in_radians_are_named(reduced: Reduce) -> None:
    change = all_of(*(scaled(f"A{k}", np.pi / 180.0, slice(ROW, ROW + 1)) for k in range(1, 7)))
    fault = fault_of(reduced, "01", change)
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, AT_ROW)
    assert fault.file == "raw/poses.csv"


def test_exchanged_targets_of_a_row_are_named(reduced: Reduce) -> None:
    fault = fault_of(reduced, "03", lambda table: exchanged(table, slice(ROW, ROW + 1)))
    assert fault.place == AT_ROW
    assert fault.changes == (EXCHANGED,)


def test_angles_of_another_row_are_named(reduced: Reduce) -> None:
    def copied(table: Table) -> None:
        for joint in range(1, 7):
            table[f"A{joint}"][ROW + 1] = table[f"A{joint}"][ROW]

    fault = fault_of(reduced, "01", copied)
    assert fault.place == f"run poses, row {ROW + 2} (line {ROW + 3})"
    assert (fault.rows, fault.changes) == ((ROW + 2,), ())


def test_rows_of_one_mistake_are_one_line(reduced: Reduce) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, 1e-3, slice(ROW, ROW + 7)) for axis in PLACE)))
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, f"{AT_ROW} and others")
    assert fault.rows == tuple(range(21, 28))


def test_more_mistakes_than_are_listed_are_counted(reduced: Reduce) -> None:
    factors = (1e-3, 1e-2, 1e-1, 1.0 / 25.4)
    units = [scaled(axis, f, slice(k, k + 1)) for k, f in enumerate(factors) for axis in PLACE]
    with pytest.raises(InputError) as refused:
        reduced("01", all_of(*units, scaled("A2", -1.0, slice(5, 6)), scaled("A3", -1.0, slice(6, 7))))
    assert [fault.code for fault in refused.value.faults] == [FaultCode.UNIT_IMPLAUSIBLE] * 4 + [FaultCode.MORE_FAULTS]
    assert len(refused.value.faults[-1].rows) == 2


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


@pytest.mark.parametrize("rows", [slice(40, 80), slice(None, None, 2), slice(20, 80), slice(20, 30)])
def test_exchanged_targets_of_many_rows_are_one_line(reduced: Reduce, rows: slice) -> None:
    """Where the manifest states the targets' places on the body, those at another's place are named."""
    fault = fault_of(reduced, "03", lambda table: exchanged(table, rows))
    assert fault.code is FaultCode.KINEMATICS_MISMATCH
    assert (fault.rows, fault.changes) == (numbers(rows), (EXCHANGED,))


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
    assert fault.rows == numbers(slice(40, 80))
    assert fault.changes == (InputChange("target-order", ("target1", "target2", "target3")),)


@pytest.mark.parametrize("factor", [1e-3, 1.0 / 25.4])
def test_one_target_of_a_row_in_another_unit_is_named(reduced: Reduce, factor: float) -> None:
    change = all_of(*(scaled(f"{axis}2", factor, slice(ROW, ROW + 1)) for axis in "XYZ"))
    fault = fault_of(reduced, "03", change)
    assert (fault.code, fault.place) == (FaultCode.UNIT_IMPLAUSIBLE, AT_ROW)
    assert fault.file == "raw/poses.csv"
    assert fault.changes == (InputChange("length-factor", ("target2",), (1.0 / factor,)),)


@pytest.mark.parametrize(("rows", "factor"), [(slice(40, 80), 1e-3), (slice(20, 80), 1.0 / 25.4)])
def test_many_rows_in_another_unit_are_one_line(reduced: Reduce, rows: slice, factor: float) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(axis, factor, rows) for axis in PLACE)))
    assert (fault.code, fault.rows) == (FaultCode.UNIT_IMPLAUSIBLE, numbers(rows))
    assert fault.changes == (InputChange("length-factor", sizes=(1.0 / factor,)),)


HALVES = [slice(0, 40), slice(1, None, 2)]


@pytest.mark.parametrize(("joint", "rows"), [(1, HALVES[0]), (3, HALVES[1]), (5, HALVES[0])])
def test_a_wrong_sign_in_half_of_the_rows_is_one_line(reduced: Reduce, joint: int, rows: slice) -> None:
    fault = fault_of(reduced, "01", scaled(f"A{joint}", -1.0, rows))
    assert fault.code is FaultCode.KINEMATICS_MISMATCH
    assert fault.changes == (InputChange("direction", (f"A{joint}",)),)
    # small angles of joint 5 are right within millimetres with either sign
    assert joint == 5 or fault.rows == numbers(rows)
    assert fault.file == "raw/poses.csv"


@pytest.mark.parametrize("rows", HALVES)
@pytest.mark.parametrize(("unit", "factor"), [("rad", np.pi / 180.0), ("gon", 400.0 / 360.0)])
def test_another_unit_of_angles_in_half_of_the_rows_is_one_line(
    reduced: Reduce, unit: str, factor: float, rows: slice
) -> None:
    fault = fault_of(reduced, "01", all_of(*(scaled(f"A{k}", factor, rows) for k in range(1, 7))))
    assert (fault.code, fault.rows) == (FaultCode.UNIT_IMPLAUSIBLE, numbers(rows))
    assert fault.changes == (InputChange("angle-unit", value=unit),)


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
    wrong = set(fault.rows)
    assert wrong < set(range(41, 81))
    assert set(range(41, 81)) <= wrong | rows_in(fault.reason.split(", and perhaps in ")[1])
    assert rows_in(fault.mend.split("[[exclude]] with rows = ")[1].replace('"', "").replace("-", " to ")) == wrong


def rows_in(text: str) -> set[int]:
    """Return the rows of the list that a line has in brackets, or else after its first word."""
    stretches = re.findall(r"(\d+)(?: to (\d+))?(?=[,)\]])", text[text.rfind("(") + 1 :])
    return {row for first, last in stretches for row in range(int(first), int(last or first) + 1)}


def test_places_next_to_the_angles_of_other_rows_are_named(reduced: Reduce) -> None:
    def shifted(table: Table) -> None:
        for axis in PLACE:
            table[axis][40:] = [*table[axis][41:], table[axis][40]]

    fault = fault_of(reduced, "01", shifted)
    assert fault.place == "run poses, row 41 (line 42) and others"
    assert fault.rows == numbers(slice(40, 80))
    assert fault.changes[0].kind == "pose-order"
    assert fault.changes[0].names[:4] == ("41", "42", "42", "43")


def test_a_tracker_that_was_moved_far_is_named_by_its_rows(reduced: Reduce) -> None:
    def moved(table: Table) -> None:
        table["X1"] = [value + 50.0 * (k >= 40) for k, value in enumerate(table["X1"])]

    fault = fault_of(reduced, "01", moved)
    (change,) = fault.changes
    assert change.kind == "tracker-frame"
    # what the geometry of other poses takes up is less than a robot misses by
    assert np.linalg.norm(change.sizes[3:]) == pytest.approx(0.05, abs=5e-3)
    assert fault.rows in (numbers(slice(40, 80)), numbers(slice(0, 40)))
