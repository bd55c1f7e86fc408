"""What the values of a sheet do not show: hidden rows and columns, merged cells, formulas without a value, errors.

XML is read by expat, which fetches nothing; a document type, without which there are no entities, is refused.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import IO, TypeAlias
from xml.parsers import expat

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import PIECE, check_unpacked

PIECE_OF_XML = 1 << 16
CELLS = frozenset(("row", "c", "v", "f", "is"))
"""Elements of the rows of a worksheet of Excel."""
BYTES_A_CELL = 64
"""What calamine takes for each cell in the rectangle of a sheet, and Python for what it gives of an empty one."""


@dataclass
class Outline:
    """What stands where in a sheet; rows and columns count from 0.

    Attributes
    ----------
    merged : (top, left, bottom, right) of merged cells.
    formulas : cells whose numbers are computed. errors : cells in which a computation failed.
    n_rows, n_columns : of the rectangle that holds all cells with a value.
    """

    hidden_rows: set[int] = field(default_factory=set)
    hidden_columns: set[int] = field(default_factory=set)
    merged: list[tuple[int, int, int, int]] = field(default_factory=list)
    formulas: set[tuple[int, int]] = field(default_factory=set)
    errors: set[tuple[int, int]] = field(default_factory=set)
    n_rows: int = 0
    n_columns: int = 0

    def add_value(self, row: int, column: int) -> None:
        """Take note of a cell that holds something."""
        self.n_rows, self.n_columns = max(self.n_rows, row + 1), max(self.n_columns, column + 1)

    def check_size(self, display_name: str, place: str) -> None:
        """Raise an `InputError` where the rectangle of all cells is larger than a parser's memory."""
        PIECE.check(BYTES_A_CELL * self.n_rows * self.n_columns, display_name, place)


OutlineOf: TypeAlias = Callable[[IO[bytes], int, str], dict[str, Outline]]
"""Of an open workbook, its bytes and its name in messages: the outlines of its sheets by their names."""


class Parts:
    """The parts of a workbook, which is a zip archive, read within the limits on what it unpacks to."""

    def __init__(self, file: IO[bytes], size: int, display_name: str) -> None:
        self._archive, self._display_name = zipfile.ZipFile(file), display_name
        # what unpacks to more than its head states is damaged for zipfile
        self.unpacked = sum(part.file_size for part in self._archive.infolist())
        check_unpacked(self.unpacked, size, display_name)
        names = self._archive.namelist()
        self.names = set(names)
        if len(self.names) < len(names):  # of which another library may take the other
            raise self.damaged("it holds two parts of one name")

    def read(
        self, name: str, begin: Callable[[str, dict[str, str]], None], end: Callable[[str], None] | None = None
    ) -> None:
        """Call `begin` with the name and attributes of each element of a part, `end` at its end, without spaces."""
        if name not in self.names:
            raise self.damaged(f"it has no part {name}")
        parser = expat.ParserCreate(namespace_separator=" ")
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        names: dict[str, str] = {}

        def start(full: str, attributes: dict[str, str]) -> None:
            name = names.get(full) or names.setdefault(full, full.rpartition(" ")[2])
            if name not in CELLS:  # of millions: their attributes have no space
                attributes = {_attribute(key): value for key, value in attributes.items()}
            begin(name, attributes)

        parser.StartElementHandler = start
        if end is not None:
            parser.EndElementHandler = lambda full: end(full.rpartition(" ")[2])
        with self._archive.open(name) as stream:
            while piece := stream.read(PIECE_OF_XML):
                parser.Parse(piece)
        parser.Parse(b"", True)

    def damaged(self, reason: str) -> InputError:
        """Return the fault of a file that is no whole workbook."""
        mend = "open it in a spreadsheet program, and save it again"
        return InputError.at(FaultCode.FILE_DAMAGED, self._display_name, "", reason, mend)

    def _refuse_doctype(self, *_: object) -> None:
        reason, mend = "its XML declares a document type", "open it in a spreadsheet program, and save it again"
        raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, self._display_name, "", reason, mend)


def _attribute(full: str) -> str:
    """Return an attribute's name without its space; what LibreOffice adds of its own has the names of others."""
    space, _, name = full.rpartition(" ")
    return f"calcext:{name}" if "calcext" in space else name


def cell_name(row: int, column: int) -> str:
    """Return a cell's name in a spreadsheet.

    Examples
    --------
    >>> cell_name(0, 0), cell_name(16, 26), cell_name(1048575, 16383)
    ('A1', 'AA17', 'XFD1048576')
    """
    letters = ""
    column += 1
    while column:
        column, letter = divmod(column - 1, 26)
        letters = chr(ord("A") + letter) + letters
    return f"{letters}{row + 1}"


_CELL = re.compile(r"\$?([A-Z]{1,3})\$?([1-9]\d{0,6})", re.ASCII)


def place_of_cell(name: str) -> tuple[int, int] | None:
    """Return the row and column, from 0, of a cell's name; None where it is none.

    Examples
    --------
    >>> place_of_cell("XFD1048576"), place_of_cell("AA17"), place_of_cell("17")
    ((1048575, 16383), (16, 26), None)
    """
    match = _CELL.fullmatch(name)
    if match is None:
        return None
    column = 0
    for letter in match[1]:
        column = 26 * column + ord(letter) - ord("A") + 1
    return int(match[2]) - 1, column - 1


def is_true(attributes: Mapping[str, str], name: str) -> bool:
    """Return whether an attribute of XML is true."""
    return attributes.get(name) in ("1", "true")
