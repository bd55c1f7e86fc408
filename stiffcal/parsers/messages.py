"""Messages between stiffcal and the child process that parses logs: a line of JSON, and behind it arrays as they are.

Why not pickles: what has parsed a stranger's file must not be able to make objects here.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import Batch, Options, WantedColumns

Document: TypeAlias = Mapping[str, Any]

CODES, NUMBERS = np.dtype("<i4"), np.dtype("<f8")


@dataclass(frozen=True)
class Allowance:
    """What parsing one log may take."""

    silent_s: float
    """Processor time until the first rows, and from some rows to the next, s."""
    whole_s: float
    """Processor time in all, s; more for what is sent."""
    memory: int
    """Memory beyond what the process has at the beginning, bytes."""
    unpacked: int
    """Bytes once unpacked: of the largest temporary file, and of all that a parser counts."""


@dataclass(frozen=True)
class Request:
    """Which log is to be parsed."""

    log_format: str
    path: Path
    options: Options
    display_name: str
    wanted: WantedColumns | None
    """Columns that must be there; None: whichever there are."""
    with_rows: bool
    """False: the header alone."""
    allowance: Allowance
    scratch: str
    """A folder for temporary files."""

    def message(self) -> bytes:
        """Return it as a message."""
        wanted = self.wanted
        return _joined(
            {
                "format": self.log_format,
                "path": os.fspath(self.path),
                "options": dict(self.options),
                "name": self.display_name,
                "wanted": None if wanted is None else [wanted.numbers, wanted.texts, wanted.times, sorted(wanted.gaps)],
                "rows": self.with_rows,
                "allowance": vars(self.allowance),
                "scratch": self.scratch,
            }
        )

    @classmethod
    def of(cls, message: bytes) -> Request:
        """Return the request of a message."""
        given, _ = parts_of(message)
        wanted = None
        if given["wanted"] is not None:
            numbers, texts, times, gaps = map(tuple, given["wanted"])
            wanted = WantedColumns(numbers, texts, times, frozenset(gaps))
        return cls(
            given["format"],
            Path(given["path"]),
            given["options"],
            given["name"],
            wanted,
            given["rows"],
            Allowance(**given["allowance"]),
            given["scratch"],
        )


def header_message(columns: Sequence[str], units: Mapping[str, str], n_rows: int | None) -> bytes:
    """Return the message of a log's header."""
    return _joined({"kind": "header", "columns": list(columns), "units": dict(units), "n_rows": n_rows})


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
    return _joined(head, [*numbers, *codes])


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


def fault_message(error: InputError) -> bytes:
    """Return the message of faults in a log."""
    faults = [{**fault.as_document(), "names": fault.names} for fault in error.faults]
    return _joined({"kind": "fault", "faults": faults})


def faults_of(head: Document) -> InputError:
    """Return the faults of a message."""
    return InputError(
        *(
            Fault(**{**fault, "code": FaultCode(fault["code"]), "names": tuple(fault["names"])})
            for fault in head["faults"]
        )
    )


def plain_message(kind: str, text: str = "") -> bytes:
    """Return a message that is a word: ``end``, ``memory``, ``unpacked``, or ``internal`` with the text of an exception."""
    return _joined({"kind": kind, "text": text})


def parts_of(packet: bytes) -> tuple[Document, memoryview]:
    """Return a message's document, and the bytes behind it."""
    end = packet.index(b"\n")
    return json.loads(packet[:end]), memoryview(packet)[end + 1 :]


def _joined(head: Document, arrays: Sequence[NDArray[Any]] = ()) -> bytes:
    return b"".join([json.dumps(head).encode(), b"\n", *(array.tobytes() for array in arrays)])
