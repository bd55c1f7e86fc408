"""Documents of KUKA's RobotSensorInterface, one after the other in a file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO
from xml.parsers import expat

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import LINE
from stiffcal.log_columns import Options, damaged_file_errors
from stiffcal.parsers.cells_by_name import NamedRow, OpenRows, Value

DOCUMENTS = ("Rob", "Sen")
MOST_DEEP = 20
"""Elements in elements; the protocol has two."""
MEND = "log again, or delete the line in a copy of the file"
# Elements of the controller's protocol whose attributes have a unit: actual and set angles and places.
_ANGLES, _PLACES = ("AIPos", "ASPos"), ("RIst", "RSol", "RKorr")
_DECLARATION = re.compile(rb"\s*<\?xml[^>]*\?>")


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenRows]:
    """Open a log.

    Raises
    ------
    InputError
        For a file of other XML, one that is cut off, or one that declares a document type.
    """
    with damaged_file_errors("log of RSI", display_name), open_regular(path, display_name) as file:
        yield OpenRows(lambda: _rows(file, display_name), unit_of, display_name, "document 1")


def unit_of(column: str) -> str:
    """Return the unit of a column by the protocol, "" where it has none.

    Examples
    --------
    >>> [unit_of(column) for column in ("IPOC", "AIPos.A1", "RIst.X", "RIst.A", "Delay.D")]
    ['ms', 'deg', 'mm', 'deg', '']
    """
    element, _, attribute = column.partition(".")
    if column == "IPOC":
        return "ms"
    if element in _ANGLES and attribute.startswith("A"):
        return "deg"
    if element in _PLACES:
        return "mm" if attribute in ("X", "Y", "Z") else "deg" if attribute in ("A", "B", "C") else ""
    return ""


def _rows(file: IO[bytes], display_name: str) -> Iterator[NamedRow]:
    file.seek(0)
    reader = _Documents(display_name)
    while line := file.readline(LINE.most + 1):
        reader.feed(line)
        yield from reader.take()
    reader.close()


class _Documents:
    """Takes lines, gives documents. The parser is given one document around all, in which no entity can be declared."""

    def __init__(self, display_name: str) -> None:
        self._display_name, self._line = display_name, 0
        self._rows: list[NamedRow] = []
        self._values: dict[str, Value] = {}
        self._path: list[str] = []
        self._text: list[str] = []
        self._parser = expat.ParserCreate()
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._begin
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._take_text
        self._parser.Parse(b"<all>")

    def feed(self, line: bytes) -> None:
        """Take a line."""
        self._line += 1
        LINE.check(len(line), self._display_name, f"line {self._line}")
        if self._line == 1:
            line = line.removeprefix(b"\xef\xbb\xbf")
        try:
            self._parser.Parse(_DECLARATION.sub(b"", line) if line.lstrip().startswith(b"<?xml") else line)
        except expat.ExpatError as error:
            reason = f"no XML of RSI: {expat.ErrorString(error.code)}"
            raise self._fault(FaultCode.SYNTAX_INVALID, reason) from None

    def take(self) -> list[NamedRow]:
        """Return the documents that are whole."""
        rows, self._rows = self._rows, []
        return rows

    def close(self) -> None:
        """Raise an `InputError` where the last document is not whole."""
        if len(self._path) > 1:
            raise self._fault(FaultCode.FILE_INCOMPLETE, "the file is cut off in the middle of a document")

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        self._path.append(name)
        self._text = []
        if len(self._path) > MOST_DEEP:
            raise self._fault(FaultCode.SYNTAX_INVALID, f"more than {MOST_DEEP} elements in elements")
        if len(self._path) == 2:
            if name not in DOCUMENTS:
                raise self._fault(FaultCode.FORMAT_UNKNOWN, f"XML of another kind: element {name!r}, not Rob or Sen")
            self._values = {}
        elif len(self._path) > 2:
            path = ".".join(self._path[2:])
            self._set({f"{path}.{key}": value.strip() for key, value in attributes.items()})

    def _take_text(self, text: str) -> None:
        if len(self._path) == 1 and text.strip():
            raise self._fault(FaultCode.SYNTAX_INVALID, "text between the documents")
        self._text.append(text)

    def _end(self, name: str) -> None:
        if len(self._path) == 1:
            raise self._fault(FaultCode.SYNTAX_INVALID, "an element ends that has not begun")
        if len(self._path) == 2:
            self._rows.append(NamedRow(f"line {self._line}", self._values))
        elif len(self._path) > 2 and (text := "".join(self._text).strip()):
            self._set({".".join(self._path[2:]): text})
        self._path.pop()
        self._text = []

    def _set(self, values: dict[str, str]) -> None:
        for name, value in values.items():
            if name in self._values:
                raise self._fault(FaultCode.KEY_CONFLICT, f"{name} stands twice in a document")
            self._values[name] = value

    def _fault(self, code: FaultCode, reason: str) -> InputError:
        return InputError.at(code, self._display_name, f"line {self._line}", reason, MEND)
