"""Writes workbooks for tests, and spoils parts of them."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import xlsxwriter

Cells = Sequence[Sequence[object]]


def write_xlsx(path: Path, sheets: Mapping[str, Cells], **options: object) -> Path:
    """Write sheets of words and numbers; `options`: of xlsxwriter."""
    with xlsxwriter.Workbook(path, {"strings_to_formulas": False, **options}) as book:
        for name, rows in sheets.items():
            sheet = book.add_worksheet(name)
            for number, row in enumerate(rows):
                sheet.write_row(number, 0, row)
    return path


def with_parts(path: Path, parts: Mapping[str, bytes], *, leave_out: Sequence[str] = ()) -> Path:
    """Write a workbook anew with other parts in place of its own; returns the path."""
    with zipfile.ZipFile(path) as archive:
        held = {name: archive.read(name) for name in archive.namelist() if name not in leave_out}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in {**held, **parts}.items():
            archive.writestr(name, content)
    return path


def part(path: Path, name: str) -> bytes:
    """Return a part of a workbook."""
    with zipfile.ZipFile(path) as archive:
        return archive.read(name)
