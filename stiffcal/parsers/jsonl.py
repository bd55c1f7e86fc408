"""JSON lines: an object a line."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import LINE
from stiffcal.log_columns import Options, damaged_file_errors
from stiffcal.parsers.cells_by_name import NamedRow, OpenRows, Value

MEND = "log again, or delete the line in a copy of the file"
_LARGEST = 10**300


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenRows]:
    """Open a log.

    Raises
    ------
    InputError
        For a line that is no object, one that is cut off, one with a key twice, an empty file.
    """
    with damaged_file_errors("file of JSON lines", display_name), open_regular(path, display_name) as file:
        yield OpenRows(lambda: _rows(file, display_name), lambda _: "", display_name, "line 1")


def _rows(file: IO[bytes], display_name: str) -> Iterator[NamedRow]:
    file.seek(0)
    number = 0
    while line := file.readline(LINE.most + 1):
        number += 1
        place = f"line {number}"
        LINE.check(len(line), display_name, place)
        if number == 1:
            line = line.removeprefix(b"\xef\xbb\xbf")
        if not line.strip():
            continue
        yield NamedRow(place, dict(_values(_parsed(line, display_name, place), "")))


def _parsed(line: bytes, display_name: str, place: str) -> object:
    """Return the object of a line; of one that is none, or not whole, an `InputError`."""

    def unique(pairs: Sequence[tuple[str, object]]) -> dict[str, object]:
        found = dict(pairs)
        if len(found) < len(pairs):
            raise InputError.at(FaultCode.KEY_CONFLICT, display_name, place, "a key stands there twice", MEND)
        return found

    try:
        value = json.loads(line, object_pairs_hook=unique)
    except (ValueError, RecursionError) as error:
        if line.lstrip()[:1] != b"{":
            raise _no_object(display_name, place) from None
        if not line.endswith(b"\n"):
            reason = "the file is cut off in the middle of a line"
            raise InputError.at(FaultCode.FILE_INCOMPLETE, display_name, place, reason, MEND) from None
        reason = f"no JSON: {str(error).splitlines()[0]}"
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, place, reason, MEND) from None
    if not isinstance(value, dict):
        raise _no_object(display_name, place)
    return value


def _no_object(display_name: str, place: str) -> InputError:
    reason = "the line is no JSON object"
    mend = 'write one object a line, as pandas does: frame.to_json(file, orient="records", lines=True)'
    return InputError.at(FaultCode.SYNTAX_INVALID, display_name, place, reason, mend)


def _values(item: object, path: str) -> Iterator[tuple[str, Value]]:
    """Yield the path and value of all that is no object or list."""
    if isinstance(item, dict):
        for key, value in item.items():
            yield from _values(value, f"{path}.{key}" if path else str(key))
    elif isinstance(item, list):
        for k, value in enumerate(item):
            yield from _values(value, f"{path}[{k}]")
    elif isinstance(item, int) and abs(item) > _LARGEST:
        yield path, float("inf")  # as a number that is not finite it is refused where it is wanted
    elif item is None or isinstance(item, str | float | int | bool):
        yield path, item
