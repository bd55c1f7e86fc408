"""Workbooks in and out: the same campaign, poses and loads as from text; no text that is written is a formula."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
import xlsxwriter
from python_calamine import CalamineWorkbook

from stiffcal.compensation.load_table import read_load_table
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.from_table import draft_campaign
from stiffcal.readers import WantedColumns, find_reader
from stiffcal.store.table_files import write_table
from stiffcal.store.workbook import check_size
from stiffcal.trust.output_kinds import EXPORT
from tests.laboratory.log_reading import read_columns
from tests.laboratory.workbooks import write_xlsx

JOINTS = ("A1", "A2", "A3")
NAMES = [*JOINTS, "Fx", "Fy", "Fz", "dx", "dy", "dz"]
ROWS = [[10.0 * k, -70.0, 60.0, 100.0, 0.0, -8.0 * k, 0.01 * k, 0.0, -0.2] for k in range(1, 6)]


def text_table(path: Path) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([NAMES, *ROWS])
    return path


def test_a_sheet_proposes_what_text_proposes(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    book = write_xlsx(tmp_path / "x" / "table.xlsx", {"Notes": [["a title"]], "data": [["Title"], [], NAMES, *ROWS]})
    by_text = draft_campaign([text_table(tmp_path / "table.csv")], tool=(0.0, 0.0, 0.2))
    by_sheet = draft_campaign([book], tool=(0.0, 0.0, 0.2))
    source = 'file = "raw/table.xlsx"\nxlsx = { sheet = "data" }\n'
    assert by_sheet.manifest == by_text.manifest.replace('file = "raw/table.csv"\n', source)
    assert by_sheet.robot == by_text.robot


def test_what_a_spreadsheet_hides_is_said_in_the_proposal_and_of_poses(tmp_path: Path) -> None:
    with xlsxwriter.Workbook(tmp_path / "table.xlsx") as book:
        sheet = book.add_worksheet("data")
        for number, row in enumerate([NAMES, *ROWS]):
            sheet.write_row(number, 0, row)
        sheet.set_row(3, None, None, {"hidden": True})
    (remark,) = draft_campaign([tmp_path / "table.xlsx"], tool=(0.0, 0.0, 0.2)).remarks
    assert "row 4" in remark
    assert any("row 4" in doubt for doubt in read_load_table(tmp_path / "table.xlsx", JOINTS, True).doubts)


@pytest.mark.parametrize("ending", [".xlsx", ".npz"])
def test_poses_and_loads_are_those_of_text(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"poses{ending}"
    if ending == ".xlsx":
        write_xlsx(path, {"data": [["Title"], NAMES, ["deg"] * 3 + ["N"] * 3 + ["mm"] * 3, *ROWS]})
    else:
        np.savez(path, **dict(zip(NAMES, np.array(ROWS).T, strict=True)))
    by_text = read_load_table(text_table(tmp_path / "poses.csv"), JOINTS, True)
    found = read_load_table(path, JOINTS, True)
    assert np.array_equal(found.joints, by_text.joints)
    assert np.array_equal(found.wrench, by_text.wrench)


def test_a_cell_of_poses_that_is_no_number_is_named(tmp_path: Path) -> None:
    rows = [list(row) for row in ROWS]
    path = write_xlsx(tmp_path / "poses.xlsx", {"data": [NAMES, *rows[:2], ["x", *rows[2][1:]], *rows[3:]]})
    with pytest.raises(InputError) as caught:
        read_load_table(path, JOINTS, True)
    assert caught.value.code == FaultCode.NUMBER_INVALID
    assert "cell A4" in caught.value.place


TABLE: dict[str, Any] = {
    "run": ["=1+1", "@x", "https://a.b"],
    "row": [1, 2, 3],
    "Fx [N]": [0.1, float("nan"), -1e-300],
    "ok": [True] * 3,
}


def test_a_table_is_written_as_it_is_and_text_is_no_formula(tmp_path: Path) -> None:
    write_table(pa.table(TABLE), tmp_path / "states.xlsx", EXPORT)
    write_table(pa.table(TABLE), tmp_path / "again.xlsx", EXPORT)
    assert (tmp_path / "states.xlsx").read_bytes() == (tmp_path / "again.xlsx").read_bytes()
    head, *rows = CalamineWorkbook.from_path(tmp_path / "states.xlsx").get_sheet_by_index(0).to_python()
    assert head == list(TABLE)
    assert rows == [["=1+1", 1.0, 0.1, True], ["@x", 2.0, "", True], ["https://a.b", 3.0, -1e-300, True]]
    path = tmp_path / "states.xlsx"
    gaps = WantedColumns(("row", "Fx [N]"), ("run",), gaps=frozenset(("Fx [N]",)))
    found = read_columns(find_reader(path), path, {}, gaps)
    assert found["run"].tolist() == TABLE["run"]
    assert np.array_equal(found["Fx [N]"], np.array(TABLE["Fx [N]"]), equal_nan=True)


def test_a_table_that_no_sheet_holds_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        check_size("states.xlsx", 1_048_576, 3)
    assert caught.value.code == FaultCode.SIZE_EXCEEDED
    check_size("states.xlsx", 1_048_575, 16_384)
