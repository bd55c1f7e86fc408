"""What travels between stiffcal and the child process that parses logs: the request, headers, rows."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from stiffcal.bounded_work.messages import Document, joined
from stiffcal.log_columns import Batch, Options, WantedColumns

Asked: TypeAlias = Literal["tables", "header", "rows", "first rows"]
"""Of a log: the tables in it, what it states, all rows, or the first ones of columns of unknown kind."""
CODES, NUMBERS = np.dtype("<i4"), np.dtype("<f8")


@dataclass(frozen=True)
class LogHeader:
    """What a log states of itself.

    Attributes
    ----------
    columns, units, n_rows, remarks, uneven : as `OpenLog` has them. options : as understood, found ones included.
    """

    columns: tuple[str, ...]
    units: Mapping[str, str]
    n_rows: int | None
    options: Mapping[str, object] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    uneven: bool = False


@dataclass(frozen=True)
class LogRequest:
    """Which log is to be parsed."""

    log_format: str
    path: Path
    options: Options
    display_name: str
    wanted: WantedColumns | None
    """Columns that must be there; None: whichever there are."""
    asked: Asked

    def values(self) -> Document:
        """Return it as a document."""
        wanted = self.wanted
        return {
            "format": self.log_format,
            "path": os.fspath(self.path),
            "options": dict(self.options),
            "name": self.display_name,
            "wanted": None if wanted is None else _wanted_parts(wanted),
            "asked": self.asked,
        }

    @classmethod
    def of(cls, given: Document) -> LogRequest:
        """Return the request of a document."""
        wanted = None
        if given["wanted"] is not None:
            *names, order = given["wanted"]
            numbers, texts, times, gaps, unjudged = map(tuple, names)
            wanted = WantedColumns(numbers, texts, times, frozenset(gaps), frozenset(unjudged), str(order))
        return cls(given["format"], Path(given["path"]), given["options"], given["name"], wanted, given["asked"])


def _wanted_parts(wanted: WantedColumns) -> list[object]:
    names = (wanted.numbers, wanted.texts, wanted.times, sorted(wanted.gaps), sorted(wanted.unjudged))
    return [*names, wanted.date_order]


def header_message(header: LogHeader) -> bytes:
    """Return the message of a log's header."""
    return joined({"kind": "header", **asdict(header)})


def header_of(head: Document) -> LogHeader:
    """Return the header of a message."""
    return LogHeader(
        tuple(map(str, head["columns"])),
        {str(name): str(unit) for name, unit in head["units"].items()},
        head["n_rows"],
        dict(head["options"]),
        tuple(map(str, head["remarks"])),
        bool(head["uneven"]),
    )


def tables_message(tables: Sequence[Options]) -> bytes:
    """Return the message of the tables in a log, each as the options that choose it."""
    return joined({"kind": "tables", "tables": [dict(table) for table in tables]})


def batch_message(batch: Batch) -> bytes:
    """Return the message of some rows: of words each once, and which of them stands in each row."""
    words: dict[str, list[str]] = {}
    codes = []
    for name, cells in batch.texts.items():
        number = {word: k for k, word in enumerate(dict.fromkeys(cells))}
        words[name] = list(number)
        codes.append(np.fromiter((number[cell] for cell in cells), CODES, len(cells)))
    numbers = [np.ascontiguousarray(values, NUMBERS) for values in batch.numbers.values()]
    head = {
        "kind": "batch", "first_row": batch.first_row, "n_rows": len(batch), "numbers": list(batch.numbers),
        "words": words,
    }  # fmt: skip
    return joined(head, [*numbers, *codes])


def batch_of(head: Document, rest: memoryview) -> Batch:
    """Return the rows of a message."""
    n_rows, at = int(head["n_rows"]), 0
    numbers, texts = {}, {}
    for name in head["numbers"]:
        numbers[str(name)] = np.frombuffer(rest, NUMBERS, n_rows, at).astype(np.float64)
        at += n_rows * NUMBERS.itemsize
    for name, words in head["words"].items():
        codes = np.frombuffer(rest, CODES, n_rows, at).tolist()
        at += n_rows * CODES.itemsize
        texts[str(name)] = [words[code] for code in codes]
    return Batch(int(head["first_row"]), numbers, texts)
