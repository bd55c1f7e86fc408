"""Workbooks: values as they are, what a spreadsheet hides is said, what it did not compute refused; hostile ones."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from datetime import UTC, datetime, time, timedelta
from pathlib import Path

import numpy as np
import pytest
import xlsxwriter

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from tests.laboratory.log_reading import parse_here, read_columns
from tests.laboratory.workbooks import part, with_parts, write_xlsx

SHEET = "xl/worksheets/sheet1.xml"
ROWS: list[list[object]] = [["t", "Fx", "run"], [0.0, -1.5, "a"], [0.1, 1e-300, "a"], [0.2, 123456.789, "b"]]
WANTED = WantedColumns(("t", "Fx"), ("run",))


def fault(path: Path, wanted: WantedColumns, **options: object) -> tuple[FaultCode, str]:
    with pytest.raises(InputError) as caught:
        read_columns(find_reader(path), path, options, wanted, "raw/log.xlsx")
    assert "\n" not in str(caught.value)
    assert caught.value.file == "raw/log.xlsx"
    return caught.value.code, caught.value.place


def book_of(path: Path, fill: Callable[[xlsxwriter.Workbook, xlsxwriter.worksheet.Worksheet], None]) -> Path:
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet("log")
        sheet.write_row(0, 0, ["t", "Fx"])
        for k in range(4):
            sheet.write_row(k + 1, 0, [0.1 * k, float(k)])
        fill(book, sheet)
    return path


def test_values_are_those_in_the_file_in_batches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parse_here(monkeypatch, 2)
    path = write_xlsx(tmp_path / "log.xlsx", {"log": ROWS})
    found = read_columns(find_reader(path), path, {}, WANTED)
    assert found["Fx"].tolist() == [-1.5, 1e-300, 123456.789]
    assert found["run"].tolist() == ["a", "a", "b"]


@pytest.mark.parametrize("mark", [",", "."])
def test_numbers_that_are_stored_as_texts_are_numbers(tmp_path: Path, mark: str) -> None:
    rows: list[list[object]] = [["t", "Fx"]]
    for k in range(4):
        rows.append([f"0.{k}".replace(".", mark), f"{k}.25".replace(".", mark)])
    path = write_xlsx(tmp_path / "log.xlsx", {"log": rows})
    found = read_columns(find_reader(path), path, {}, WantedColumns(("t", "Fx")))
    assert found["Fx"].tolist() == [0.25, 1.25, 2.25, 3.25]


def test_titles_blank_rows_and_units_stand_above(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        ["Stiffness, hall 4"],
        [],
        ["", "t", "Fx"],
        ["", "ms", "N"],
        *([["", 4 * k, 1.5 + k] for k in range(5)]),
        [],
        ["", 20, 6.5],
    ]
    path = write_xlsx(tmp_path / "log.xlsx", {"Notes": [["none"]], "log": rows})
    header = find_reader(path).read_header(path, {})
    assert (header.units, header.n_rows, header.options["sheet"]) == ({"t": "ms", "Fx": "N"}, 6, "log")
    assert read_columns(find_reader(path), path, {}, WantedColumns(("t", "Fx")))["Fx"].tolist() == [
        1.5,
        2.5,
        3.5,
        4.5,
        5.5,
        6.5,
    ]
    assert find_reader(path).read_header(path, {"skip_rows": 4}).columns[1:] == ("0", "1.5")


def test_of_several_sheets_with_numbers_one_is_chosen_by_name(tmp_path: Path) -> None:
    path = write_xlsx(tmp_path / "log.xlsx", {"log": ROWS, "other": ROWS, "words": [["a"]]})
    assert fault(path, WANTED) == (FaultCode.LOG_PART_AMBIGUOUS, "xlsx.sheet")
    assert fault(path, WANTED, sheet="Log") == (FaultCode.LOG_PART_MISSING, "xlsx.sheet")
    assert read_columns(find_reader(path), path, {"sheet": "other"}, WANTED)["t"].tolist() == [0.0, 0.1, 0.2]
    assert fault(write_xlsx(tmp_path / "words.xlsx", {"words": [["a"]]}), WANTED)[0] == FaultCode.FILE_EMPTY


def test_what_a_spreadsheet_hides_is_said(tmp_path: Path) -> None:
    def hide(book: xlsxwriter.Workbook, sheet: xlsxwriter.worksheet.Worksheet) -> None:
        sheet.set_row(2, None, None, {"hidden": True})
        sheet.set_column(1, 1, None, None, {"hidden": True})
        book.add_worksheet("old").hide()

    path = book_of(tmp_path / "log.xlsx", hide)
    remarks = find_reader(path).read_header(path, {}).remarks
    assert [words for words in ("row 3", "'Fx'", "'old'") if any(words in remark for remark in remarks)] == [
        "row 3", "'Fx'", "'old'",
    ]  # fmt: skip
    assert len(read_columns(find_reader(path), path, {}, WantedColumns(("t",)))["t"]) == 4
    assert not find_reader(path).read_header(write_xlsx(tmp_path / "plain.xlsx", {"log": ROWS}), {}).remarks


def test_merged_words_hold_for_every_cell_and_merged_numbers_for_none(tmp_path: Path) -> None:
    def merge(book: xlsxwriter.Workbook, sheet: xlsxwriter.worksheet.Worksheet) -> None:
        sheet.write_row(0, 2, ["run", "dx"])
        sheet.merge_range(1, 2, 4, 2, "pose1")
        sheet.merge_range(2, 3, 3, 3, 0.5)
        sheet.write(1, 3, 0.25)

    path = book_of(tmp_path / "log.xlsx", merge)
    assert set(read_columns(find_reader(path), path, {}, WantedColumns(("t",), ("run",)))["run"]) == {"pose1"}
    code, place = fault(path, WantedColumns(("dx",)))
    assert code == FaultCode.CELL_EMPTY
    assert "cell D4" in place


def test_a_name_above_several_columns_is_part_of_theirs(tmp_path: Path) -> None:
    with xlsxwriter.Workbook(tmp_path / "log.xlsx") as book:
        sheet = book.add_worksheet("log")
        sheet.merge_range(0, 1, 0, 3, "Force [N]")
        sheet.merge_range(0, 4, 0, 6, "Moment [Nm]")
        sheet.write_row(1, 0, ["t", "X", "Y", "Z", "X", "Y", "Z"])
        for k in range(3):
            sheet.write_row(k + 2, 0, [float(k)] * 7)
    header = find_reader(tmp_path / "log.xlsx").read_header(tmp_path / "log.xlsx", {})
    assert header.columns == ("t", "Force X", "Force Y", "Force Z", "Moment X", "Moment Y", "Moment Z")
    assert (header.units["Force X"], header.units["Moment Z"]) == ("N", "Nm")


@pytest.mark.parametrize("date_1904", [False, True])
def test_dates_go_by_the_calendar_of_the_workbook(tmp_path: Path, date_1904: bool) -> None:
    moments = [datetime(2026, 11, 20, 10, 15, 30, 123000, tzinfo=UTC), datetime(2026, 11, 20, tzinfo=UTC)]
    with xlsxwriter.Workbook(tmp_path / "log.xlsx", {"date_1904": date_1904, "remove_timezone": True}) as book:
        sheet = book.add_worksheet("log")
        format_of = book.add_format
        sheet.write_row(0, 0, ["when", "Fx", "clock", "elapsed"])
        for k, moment in enumerate(moments):
            sheet.write_datetime(k + 1, 0, moment, format_of({"num_format": "dd.mm.yyyy hh:mm:ss.000"}))
            sheet.write_number(k + 1, 1, 1.0)
            sheet.write_datetime(k + 1, 2, time(10, 15, 30, 500000), format_of({"num_format": "hh:mm:ss.000"}))
            sheet.write_datetime(k + 1, 3, timedelta(hours=30), format_of({"num_format": "[h]:mm:ss"}))
    path = tmp_path / "log.xlsx"
    found = read_columns(find_reader(path), path, {}, WantedColumns(("clock", "elapsed"), (), ("when",)))
    assert np.allclose(found["when"], [moment.timestamp() for moment in moments], rtol=0, atol=1e-6)
    assert np.allclose(found["clock"], 36930.5, rtol=0, atol=1e-6)
    assert found["elapsed"].tolist() == [108000.0, 108000.0]
    assert fault(path, WantedColumns(("when",)))[0] == FaultCode.NUMBER_INVALID


@pytest.mark.parametrize(
    ("formula", "value", "code"),
    [("=1+1", 2.0, None), ("=1+1", "", FaultCode.CELL_EMPTY), ("=1/0", "#DIV/0!", FaultCode.NUMBER_INVALID)],
)
def test_of_formulas_the_value_counts_that_is_in_the_file(
    tmp_path: Path, formula: str, value: float | str, code: FaultCode | None
) -> None:
    path = book_of(tmp_path / "log.xlsx", lambda _, sheet: [sheet.write_formula(2, 1, formula, None, value), None][1])
    if code is None:
        assert read_columns(find_reader(path), path, {}, WantedColumns(("Fx",)))["Fx"][1] == 2.0
        return
    gaps = frozenset(("Fx",))  # where an empty cell is a missing reading, a cell that was not computed is none
    for wanted in (WantedColumns(("Fx",)), WantedColumns(("Fx",), gaps=gaps)):
        found, place = fault(path, wanted)
        assert found == code
        assert "cell B3" in place
    assert len(read_columns(find_reader(path), path, {}, WantedColumns(("t",)))["t"]) == 4


def test_cells_that_are_no_numbers_are_named(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        ["t", "a", "b", "c", "d"],
        [0, "1.5", "x", "", True],
        [1, "2.5", 1.0, 1.0, 1.0],
        [2, 3.5, 1, 1, 1],
    ]
    path = write_xlsx(tmp_path / "log.xlsx", {"log": rows})
    assert read_columns(find_reader(path), path, {}, WantedColumns(("a",)))["a"].tolist() == [1.5, 2.5, 3.5]
    for name, code in (("b", FaultCode.NUMBER_INVALID), ("c", FaultCode.CELL_EMPTY), ("d", FaultCode.NUMBER_INVALID)):
        found, place = fault(path, WantedColumns((name,)))
        assert found == code
        assert "2, column" in place
    gaps = read_columns(find_reader(path), path, {}, WantedColumns(("c",), gaps=frozenset(("c",))))
    assert np.isnan(gaps["c"][0])
    german = write_xlsx(tmp_path / "german.xlsx", {"log": [["t", "a"], [0, "1,5"], [1, "2,5"]]})
    assert read_columns(find_reader(german), german, {"decimal": ","}, WantedColumns(("a",)))["a"].tolist() == [
        1.5,
        2.5,
    ]


def far_cell(path: Path) -> None:
    cell = b'<row r="1048576"><c r="XFD1048576"><v>1</v></c></row></sheetData>'
    with_parts(path, {SHEET: part(path, SHEET).replace(b"</sheetData>", cell)})


def entities(path: Path) -> None:
    text = part(path, SHEET)
    declared = b'<!DOCTYPE x [<!ENTITY a "1"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    with_parts(path, {SHEET: text.replace(b"?>", b"?>" + declared, 1)})


def outside(path: Path) -> None:
    name = "xl/_rels/workbook.xml.rels"
    text = part(path, name).replace(b'Target="worksheets/sheet1.xml"', b'Target="../../../../etc/passwd"')
    with_parts(path, {name: text})


def linked(path: Path) -> None:
    name = "xl/_rels/workbook.xml.rels"
    text = part(path, name).replace(
        b'Target="worksheets/sheet1.xml"', b'Target="file:///etc/passwd" TargetMode="External"'
    )
    with_parts(path, {name: text})


def without_sheet(path: Path) -> None:
    with_parts(path, {}, leave_out=(SHEET,))


def twice(path: Path) -> None:
    text = part(path, SHEET)
    with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.writestr(SHEET, text.replace(b"-1.5", b"-2.5"))


def cut_off(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def wrong_row(path: Path) -> None:
    with_parts(path, {SHEET: part(path, SHEET).replace(b'<row r="3"', b'<row r="7"')})


def old_excel(path: Path) -> None:
    path.write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(5000))


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (far_cell, FaultCode.SIZE_EXCEEDED),
        (entities, FaultCode.CONTENT_UNSUPPORTED), (old_excel, FaultCode.CONTENT_UNSUPPORTED),
        (outside, FaultCode.FILE_EMPTY), (linked, FaultCode.FILE_EMPTY), (without_sheet, FaultCode.FILE_DAMAGED),
        (twice, FaultCode.FILE_DAMAGED), (cut_off, FaultCode.FILE_DAMAGED), (wrong_row, FaultCode.FILE_DAMAGED),
    ],
)  # fmt: skip
def test_a_hostile_workbook_is_one_line(tmp_path: Path, spoil: Callable[[Path], None], code: FaultCode) -> None:
    path = write_xlsx(tmp_path / "log.xlsx", {"log": ROWS})
    spoil(path)
    assert fault(path, WANTED)[0] == code


def test_a_workbook_that_unpacks_to_more_than_is_allowed_is_refused_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parse_here(monkeypatch, 100)
    path = write_xlsx(tmp_path / "log.xlsx", {"log": ROWS})
    rows = b"<row>" + b" " * (2 << 20) + b"</row></sheetData>"
    with_parts(path, {SHEET: part(path, SHEET).replace(b"</sheetData>", rows)})
    assert len(read_columns(find_reader(path), path, {}, WANTED)["t"]) == 3
    monkeypatch.setenv("STIFFCAL_MAX_UNPACKED", "1 MiB")
    assert fault(path, WANTED)[0] == FaultCode.SIZE_EXCEEDED


def test_rows_of_means_below_a_table_are_named_all_at_once_and_can_be_left_out(tmp_path: Path) -> None:
    rows: list[list[object]] = [["t", "Fx"], *map(list, np.random.default_rng(1).random((6, 2)).tolist())]
    path = write_xlsx(tmp_path / "log.xlsx", {"log": [*rows, ["mean", 0.5], ["max", 0.9]]})
    reader, wanted = find_reader(path), WantedColumns(("t", "Fx"))
    with pytest.raises(InputError) as caught:
        read_columns(reader, path, {}, wanted)
    assert "rows = [7, 8]" in caught.value.faults[0].mend
    unjudged = WantedColumns(("t", "Fx"), gaps=frozenset("t"), unjudged=frozenset("t"))
    found = read_columns(reader, path, {}, unjudged)
    assert np.isinf(found["t"]).tolist() == 6 * [False] + [True, True]
    first = reader.first_rows(path, {}, ["t", "Fx"])  # by which init knows a column of numbers
    assert np.isnan(first["t"]).sum() == 2
    assert len(first["Fx"]) == 8


@pytest.mark.parametrize(
    ("name", "content"),
    [("old.xls", b"\xd0\xcf\x11\xe0" + bytes(600)), ("old.xlsx", b"\xd0\xcf\x11\xe0" + bytes(600)), ("new.xlsb", b"")],
)
def test_workbooks_of_other_kinds_are_said_to_be_saved_as_xlsx(tmp_path: Path, name: str, content: bytes) -> None:
    path = tmp_path / name
    if content:
        path.write_bytes(content)
    else:
        with zipfile.ZipFile(path, "w") as file:
            file.writestr("xl/workbook.bin", b"")
    reader = find_reader(path)
    assert reader.name == "xlsx"
    with pytest.raises(InputError) as caught:
        reader.read_header(path, {}, name)
    assert caught.value.code is FaultCode.CONTENT_UNSUPPORTED
    assert ".xlsx" in caught.value.faults[0].mend


def test_text_whose_name_ends_like_a_workbooks_is_text(tmp_path: Path) -> None:
    (tmp_path / "export.xls").write_text("t\tFx\n0.0\t1.5\n0.1\t2.5\n0.2\t3.5\n", "utf-8")
    assert find_reader(tmp_path / "export.xls").name == "csv"
