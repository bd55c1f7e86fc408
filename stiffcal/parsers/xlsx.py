"""Workbooks of Excel (``.xlsx``, ``.xlsm``): macros are not run, formulas have the values they were saved with."""

from __future__ import annotations

import posixpath
from contextlib import AbstractContextManager
from pathlib import Path
from typing import IO

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import Options
from stiffcal.parsers.sheets import LIBRARIES, SAVE_AS_XLSX, open_sheet, tables_of_sheets
from stiffcal.parsers.sheets.open_sheet import OpenSheet
from stiffcal.parsers.sheets.outlines import Outline, Parts, is_true, place_of_cell

__all__ = ["LIBRARIES", "open_log", "tables"]
BINARY_BOOK = "xl/workbook.bin"
BOOK, RELATIONS = "xl/workbook.xml", "xl/_rels/workbook.xml.rels"


def open_log(path: Path, options: Options, display_name: str) -> AbstractContextManager[OpenSheet]:
    """Open a sheet of a workbook; the parameters and errors are those of `open_sheet`."""
    return open_sheet(path, options, display_name, "xlsx", outlines)


def tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose each visible sheet that holds numbers."""
    return tables_of_sheets(path, display_name, outlines)


def outlines(file: IO[bytes], size: int, display_name: str) -> dict[str, Outline]:
    """Return the outlines of the worksheets by their names.

    Raises
    ------
    InputError
        For a damaged file, one that unpacks to more than is allowed, or one with XML entities.
    """
    parts = Parts(file, size, display_name)
    if BINARY_BOOK in parts.names:
        reason = "a workbook whose parts are binary (.xlsb)"
        raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, display_name, "", reason, SAVE_AS_XLSX)
    sheets: dict[str, str] = {}
    targets: dict[str, str] = {}

    def sheet(name: str, attributes: dict[str, str]) -> None:
        if name == "sheet":
            if attributes.get("name", "") in sheets:
                raise parts.damaged("two sheets have one name")
            sheets[attributes.get("name", "")] = attributes.get("id", "")

    def relation(name: str, attributes: dict[str, str]) -> None:
        if name == "Relationship" and attributes.get("TargetMode") != "External":
            targets[attributes.get("Id", "")] = attributes.get("Target", "")

    parts.read(BOOK, sheet)
    parts.read(RELATIONS, relation)
    found = {}
    for name, relation_id in sheets.items():
        target = targets.get(relation_id, "")
        part = posixpath.normpath(posixpath.join("/xl", target)).lstrip("/")
        if part.startswith("xl/worksheets/"):  # the others are charts and dialogs
            found[name] = _outline(parts, part)
    return found


def _outline(parts: Parts, part: str) -> Outline:
    outline = Outline()
    row, column, is_text = -1, -1, False
    columns: dict[str, int | None] = {}

    def begin(name: str, attributes: dict[str, str]) -> None:
        nonlocal row, column, is_text
        if name == "c":
            reference = attributes.get("r", "")
            letters = reference.rstrip("0123456789")
            if letters not in columns:
                place = place_of_cell(f"{letters}1")
                columns[letters] = place[1] if place is not None else None
            if reference and (columns[letters] is None or reference != f"{letters}{row + 1}"):
                raise parts.damaged(f"cell {reference} stands in row {row + 1}")
            found = columns[letters]
            column = found if found is not None else column + 1
            is_text = attributes.get("t") == "str"
            if attributes.get("t") == "e":
                outline.errors.add((row, column))
        elif name == "v":
            outline.add_value(row, column)
        elif name == "f":
            outline.add_value(row, column)
            if not is_text:  # whose empty value is a value
                outline.formulas.add((row, column))
        elif name == "is":
            outline.add_value(row, column)
        elif name == "row":
            row, column = int(attributes.get("r", row + 2)) - 1, -1
            if is_true(attributes, "hidden"):
                outline.hidden_rows.add(row)
        elif name == "col" and is_true(attributes, "hidden"):
            first, last = int(attributes.get("min", 1)) - 1, int(attributes.get("max", 1))
            outline.hidden_columns.update(range(max(first, 0), min(last, 1 << 14)))
        elif name == "mergeCell":
            ends = [place_of_cell(end) for end in attributes.get("ref", "").split(":")]
            if len(ends) == 2 and ends[0] is not None and ends[1] is not None:
                outline.merged.append((*ends[0], *ends[1]))

    parts.read(part, begin)
    return outline
