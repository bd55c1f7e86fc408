"""Sheets of OpenDocument: as workbooks of Excel, with repeated rows and cells, and what LibreOffice adds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from stiffcal.readers.ods import write_ods
from tests.laboratory.log_reading import read_columns
from tests.laboratory.workbooks import part, with_parts

ROWS: list[list[str | float]] = [["Take 1"], ["t", "Fx", "run"], ["s", "N", "-"], [0.0, -1.5, "a"], [0.1, 1e-300, "b"]]
ROWS += [[0.2 + 0.1 * k, float(k), "c"] for k in range(3)]
WANTED = WantedColumns(("t", "Fx"), ("run",))
EMPTY = b"<table:table-row><table:table-cell/></table:table-row>"


def changed(path: Path, *changes: tuple[bytes, bytes]) -> Path:
    text = part(path, "content.xml")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return with_parts(path, {"content.xml": text})


def fault(path: Path, wanted: WantedColumns) -> tuple[FaultCode, str]:
    with pytest.raises(InputError) as caught:
        read_columns(find_reader(path), path, {}, wanted, "raw/log.ods")
    assert "\n" not in str(caught.value)
    return caught.value.code, caught.value.place


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_ods(tmp_path / "log.ods", ROWS)
    return tmp_path / "log.ods"


def test_values_and_units(path: Path) -> None:
    header = find_reader(path).read_header(path, {})
    assert (header.units["Fx"], header.n_rows) == ("N", 5)
    found = read_columns(find_reader(path), path, {}, WANTED)
    assert (found["Fx"].tolist(), found["run"].tolist()) == ([-1.5, 1e-300, 0.0, 1.0, 2.0], ["a", "b", "c", "c", "c"])


def test_rows_and_cells_that_stand_for_many(path: Path) -> None:
    row = b"<table:table-row>"
    cell = b'<table:table-cell office:value-type="float" office:value="1e-300"/>'
    many = b'<table:table-row table:number-rows-repeated="1048000"><table:table-cell/></table:table-row></table:table>'
    first = b'<table:table-cell office:value-type="float" office:value="0.1"/>'
    thrice = b'<table:table-row table:number-rows-repeated="3">'
    changed(
        path,
        (cell, cell.replace(b"/>", b' table:number-columns-repeated="1"/>')),
        (row + first, thrice + first),
        (b"</table:table>", many),
    )
    assert read_columns(find_reader(path), path, {}, WANTED)["Fx"].tolist() == [-1.5, *[1e-300] * 3, 0.0, 1.0, 2.0]


def test_hidden_rows_are_said_and_formulas_without_a_value_refused(path: Path) -> None:
    value = b'<table:table-cell office:value-type="float" office:value="-1.5"/>'
    zero = b'<table:table-row><table:table-cell office:value-type="float" office:value="0.0"/>'
    changed(path, (zero, zero.replace(b"row>", b'row table:visibility="filter">', 1)))
    (remark,) = find_reader(path).read_header(path, {}).remarks
    assert "row 4" in remark
    changed(path, (value, b'<table:table-cell table:formula="of:=[.A1]"/>'))
    code, place = fault(path, WANTED)
    assert code == FaultCode.CELL_EMPTY
    assert "cell B4" in place


def test_an_error_of_libreoffice_is_one(path: Path) -> None:
    value = b'<table:table-cell office:value-type="float" office:value="-1.5"/>'
    failed = (
        b'<table:table-cell xmlns:calcext="urn:org:documentfoundation:names:experimental:calc:xmlns:calcext:1.0" '
        b'table:formula="of:=1/0" office:value-type="string" office:string-value="" calcext:value-type="error">'
        b"<text:p>#DIV/0!</text:p></table:table-cell>"
    )
    changed(path, (value, failed))
    assert fault(path, WANTED)[0] == FaultCode.NUMBER_INVALID


def repeated_value(path: Path) -> None:
    cell = b'<table:table-cell table:number-columns-repeated="16384" office:value-type="float" office:value="1"/>'
    row = b'<table:table-row table:number-rows-repeated="1048000">' + cell + b"</table:table-row></table:table>"
    changed(path, (b"</table:table>", row))


def entities(path: Path) -> None:
    changed(path, (b"?>", b'?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>'))


@pytest.mark.parametrize(
    ("spoil", "code"), [(repeated_value, FaultCode.SIZE_EXCEEDED), (entities, FaultCode.CONTENT_UNSUPPORTED)]
)
def test_a_hostile_document_is_one_line(path: Path, spoil: Callable[[Path], None], code: FaultCode) -> None:
    spoil(path)
    assert fault(path, WANTED)[0] == code
