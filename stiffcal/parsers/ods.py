"""Sheets of OpenDocument (``.ods``), as LibreOffice writes them."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import IO

from stiffcal.log_columns import Options
from stiffcal.parsers.sheets import LIBRARIES, open_sheet, tables_of_sheets
from stiffcal.parsers.sheets.open_sheet import OpenSheet
from stiffcal.parsers.sheets.outlines import Outline, Parts

__all__ = ["LIBRARIES", "open_log", "tables"]
HIDDEN = ("collapse", "filter")
MOST_ROWS, MOST_COLUMNS = 1 << 20, 1 << 14


def open_log(path: Path, options: Options, display_name: str) -> AbstractContextManager[OpenSheet]:
    """Open a sheet of a document; the parameters and errors are those of `open_sheet`."""
    return open_sheet(path, options, display_name, "ods", outlines)


def tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose each visible sheet that holds numbers."""
    return tables_of_sheets(path, display_name, outlines)


def outlines(file: IO[bytes], size: int, display_name: str) -> dict[str, Outline]:
    """Return the outlines of the sheets by their names.

    Raises
    ------
    InputError
        For a damaged file, one that unpacks to more than is allowed, or one with XML entities.
    """
    parts = Parts(file, size, display_name)
    reader = _Tables(parts)
    parts.read("content.xml", reader.begin, reader.end)
    return reader.found


class _Tables:
    """Follows the elements of a document; those of a table in a cell belong to no sheet."""

    def __init__(self, parts: Parts) -> None:
        self.found: dict[str, Outline] = {}
        self._parts = parts
        self._depth = self._row = self._column = self._next_row = self._of_column = 0
        self._outline = Outline()

    def begin(self, name: str, attributes: dict[str, str]) -> None:
        """Take the beginning of an element."""
        if name == "table":
            self._depth += 1
            if self._depth == 1:
                title = attributes.get("name", "")
                if title in self.found:
                    raise self._parts.damaged("two sheets have one name")
                self._outline = self.found[title] = Outline()
                self._row = self._next_row = self._of_column = 0
        elif self._depth != 1:
            return
        elif name == "table-row":
            count = _count(attributes, "number-rows-repeated", MOST_ROWS)
            self._row, self._next_row, self._column = self._next_row, self._next_row + count, 0
            if attributes.get("visibility") in HIDDEN:
                self._outline.hidden_rows.update(range(self._row, min(self._next_row, MOST_ROWS)))
        elif name == "table-column":
            count = _count(attributes, "number-columns-repeated", MOST_COLUMNS)
            if attributes.get("visibility") in HIDDEN:
                last = min(self._of_column + count, MOST_COLUMNS)
                self._outline.hidden_columns.update(range(self._of_column, last))
            self._of_column += count
        elif name in ("table-cell", "covered-table-cell"):
            count = _count(attributes, "number-columns-repeated", MOST_COLUMNS)
            self._take(attributes, count)
            self._column += count

    def end(self, name: str) -> None:
        """Take the end of an element."""
        self._depth -= name == "table"

    def _take(self, attributes: dict[str, str], count: int) -> None:
        kind = attributes.get("value-type", "")
        if not kind and "formula" not in attributes:
            return
        right, below = self._column + count - 1, self._next_row - 1
        self._outline.add_value(below, right)
        cells = [(self._row, column) for column in range(self._column, min(right + 1, MOST_COLUMNS))]
        if attributes.get("calcext:value-type") == "error":  # which is a string for all other programs
            self._outline.errors.update(cells)
        elif "formula" in attributes and kind != "string":
            self._outline.formulas.update(cells)
        spanned = [_count(attributes, f"number-{way}-spanned", MOST_ROWS) for way in ("rows", "columns")]
        if max(spanned) > 1:
            self._outline.merged.append(
                (self._row, self._column, self._row + spanned[0] - 1, self._column + spanned[1] - 1)
            )


def _count(attributes: dict[str, str], name: str, most: int) -> int:
    """Return how often an element stands for itself."""
    text = attributes.get(name, "1")
    return min(max(int(text), 1), most) if text.isdecimal() and len(text) < 10 else 1
