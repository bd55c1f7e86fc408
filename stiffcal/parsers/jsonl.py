"""JSON: an object a line, or one document that holds a table."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import LINE, TABLE
from stiffcal.log_columns import Options, damaged_file_errors
from stiffcal.parsers.cells_by_name import NamedRow, OpenRows, Value

MEND = "log again, or delete the line in a copy of the file"
_AS_LINES = 'write one object a line, as pandas does: frame.to_json(file, orient="records", lines=True)'
_LONGEST_VECTOR = 16  # of one row: longer lists are columns
_LARGEST = 10**300
_BOM = b"\xef\xbb\xbf"


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenRows]:
    """Open a log.

    Raises
    ------
    InputError
        For a line that is no object, one that is cut off, one with a key twice, a document that holds no table, an
        empty file.
    """
    with damaged_file_errors("JSON file", display_name), open_regular(path, display_name) as file:
        rows = _rows_of_document if _is_one_document(file) else _rows
        yield OpenRows(lambda: rows(file, display_name), lambda _: "", display_name, "line 1")


def _is_one_document(file: IO[bytes]) -> bool:
    """Return whether a file is one list or object over all of its lines, or an object of containers alone."""
    file.seek(0)
    line = b""
    while not line.strip() and (line := file.readline(LINE.most + 1)):
        line = line.removeprefix(_BOM)
    bare = line.strip()
    if bare[:1] == b"[" or len(line) > LINE.most:
        return bare[:1] in (b"[", b"{")
    if bare[:1] != b"{" or bare[-1:] in b"{[,:":
        return bare[:1] == b"{"
    try:
        only = json.loads(bare)
    except (ValueError, RecursionError):
        return False  # a line that is named with its place
    if any(rest.strip() for rest in iter(lambda: file.readline(LINE.most + 1), b"")):
        return False
    values = list(only.values())
    all_hold = bool(values) and all(isinstance(value, dict | list) for value in values)
    lists = [value for value in values if isinstance(value, list) and value]
    return all_hold or any(len(value) > _LONGEST_VECTOR or isinstance(value[0], dict) for value in lists)


def _rows_of_document(file: IO[bytes], display_name: str) -> Iterator[NamedRow]:
    file.seek(0)
    content = file.read(TABLE.most + 1)
    TABLE.check(len(content), display_name)
    for k, entry in enumerate(_entries(_parsed(content.removeprefix(_BOM), display_name, ""), display_name), start=1):
        yield NamedRow(f"entry {k}", dict(_values(entry, "")))


def _entries(document: object, display_name: str) -> Iterator[object]:
    """Yield the rows of a document, each an object: those of a list, or of columns of equal length."""
    if isinstance(document, list) and document and all(isinstance(entry, dict) for entry in document):
        yield from document
        return
    if isinstance(document, dict):
        names, data = document.get("columns"), document.get("data")
        if isinstance(names, list) and isinstance(data, list):  # pandas, orient="split"
            if all(isinstance(row, list) and len(row) == len(names) for row in data):
                yield from (dict(zip(map(str, names), row, strict=True)) for row in data)
                return
        elif (columns := _columns(document)) is not None:
            yield from (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
            return
        held = [value for value in document.values() if isinstance(value, dict | list)]
        if len(held) == 1:  # next to what is stated about it
            yield from _entries(held[0], display_name)
            return
    reason = "no table: neither a list of objects nor columns of equal length"
    raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, "", reason, _AS_LINES)


def _columns(document: dict[str, object]) -> dict[str, Sequence[object]] | None:
    """Return the columns of an object, by their paths: its lists, or objects with the same keys; None: it has none."""
    inside = [value for value in document.values() if isinstance(value, dict)]
    if len(inside) == len(document) and len({tuple(value) for value in inside}) == 1:
        rows = [list(value.values()) for value in inside]
        if len(rows[0]) > 1 and not any(isinstance(value, dict | list) for row in rows for value in row):
            return dict(zip(document, rows, strict=True))  # pandas, as it writes where nothing is said
    found: dict[str, Sequence[object]] = {}

    def collect(value: object, path: str) -> None:
        if isinstance(value, list):
            found[path] = value
        elif isinstance(value, dict):
            for key, own in value.items():
                collect(own, f"{path}.{key}" if path else str(key))

    collect(document, "")
    lengths = {len(column) for column in found.values()}
    of_objects = any(isinstance(entry, dict) for column in found.values() for entry in column[:1])
    return found if len(lengths) == 1 and lengths != {0} and not (of_objects and len(found) == 1) else None


def _rows(file: IO[bytes], display_name: str) -> Iterator[NamedRow]:
    file.seek(0)
    number = 0
    while line := file.readline(LINE.most + 1):
        number += 1
        place = f"line {number}"
        LINE.check(len(line), display_name, place)
        if number == 1:
            line = line.removeprefix(_BOM)
        if not line.strip():
            continue
        yield NamedRow(place, dict(_values(_parsed(line, display_name, place), "")))


def _parsed(line: bytes, display_name: str, place: str) -> object:
    """Return the object of a line, or a document where it has no place; else an `InputError`."""

    def unique(pairs: Sequence[tuple[str, object]]) -> dict[str, object]:
        found = dict(pairs)
        if len(found) < len(pairs):
            raise InputError.at(FaultCode.KEY_CONFLICT, display_name, place, "a key stands there twice", MEND)
        return found

    try:
        value = json.loads(line, object_pairs_hook=unique)
    except (ValueError, RecursionError) as error:
        if place and line.lstrip()[:1] != b"{":
            raise _no_object(display_name, place) from None
        if place and not line.endswith(b"\n"):
            reason = "the file is cut off in the middle of a line"
            raise InputError.at(FaultCode.FILE_INCOMPLETE, display_name, place, reason, MEND) from None
        reason = f"no JSON: {str(error).splitlines()[0]}"
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, place, reason, MEND) from None
    if place and not isinstance(value, dict):
        raise _no_object(display_name, place)
    return value


def _no_object(display_name: str, place: str) -> InputError:
    reason = "the line is no JSON object"
    return InputError.at(FaultCode.SYNTAX_INVALID, display_name, place, reason, _AS_LINES)


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
