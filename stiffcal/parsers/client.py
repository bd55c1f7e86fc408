"""Asking the child process that parses logs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from stiffcal.arrays import Floats
from stiffcal.bounded_work.client import Work
from stiffcal.limits import COLUMNS, LINE, ROWS, check_unpacked
from stiffcal.log_columns import Batch, Options, WantedColumns
from stiffcal.parsers import answering
from stiffcal.parsers.messages import Asked, LogHeader, LogRequest, batch_of, header_of

MOST_TABLES = 100
"""Of a file: a bag of a whole robot holds some dozens of topics."""


@dataclass(frozen=True)
class ParsedFile:
    """A log of a binary format, to be parsed in a child process.

    Attributes
    ----------
    log_format : the parser's module. options : of the manifest, as they have been checked.
    display_name : how to call it in a fault.
    """

    log_format: str
    path: Path
    options: Options
    display_name: str

    def tables(self) -> tuple[Options, ...]:
        """Return the tables in it, each as the options that choose it; of many the first ones."""
        ((head, _),) = self._work(None, "tables").answers()
        return tuple(dict(table) for table in head["tables"][:MOST_TABLES])

    def header(self, wanted: WantedColumns | None) -> LogHeader:
        """Return what it states; with `wanted`, check that these columns are there."""
        ((head, _),) = self._work(wanted, "header").answers()
        COLUMNS.check(len(head["columns"]), self.display_name)
        return header_of(head)

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield its rows as they come.

        Raises
        ------
        InputError
            As the format's parser raises it; and where it takes more than is allowed, or ends the process.
        """
        work, sent = self._work(wanted, "rows"), 0
        with closing(work.answers()) as answers:
            for head, rest in answers:
                batch = batch_of(head, rest)
                longest = {name: max(map(len, words), default=0) for name, words in head["words"].items()}
                for name, length in longest.items():
                    LINE.check(length, self.display_name, f"column {name}")
                sent += len(rest) + sum(longest.values())
                ROWS.check(batch.first_row - 1 + len(batch), self.display_name)
                check_unpacked(sent, work.size, self.display_name)
                yield batch

    def first_rows(self, names: Sequence[str]) -> dict[str, Floats | list[str]]:
        """Return the first rows of columns of unknown kind: (n,) numbers, NaN for gaps, or n words."""
        found: dict[str, Floats | list[str]] = {}
        with closing(self._work(WantedColumns(tuple(names)), "first rows").answers()) as answers:
            for head, rest in answers:
                batch = batch_of(head, rest)
                found |= {**batch.numbers, **batch.texts}
        return found

    def _work(self, wanted: WantedColumns | None, asked: Asked) -> Work:
        request = LogRequest(self.log_format, self.path, self.options, self.display_name, wanted, asked)
        mend = "copy it again from its origin, or log again"
        return Work(answering.__name__, request.values(), _size_of(self.path), self.display_name, mend)


def _size_of(path: Path) -> int:
    """Return the bytes of a file, or of all files in a folder."""
    with suppress(OSError):
        files = path.iterdir() if path.is_dir() else (path,)
        return sum(file.stat().st_size for file in files)
    return 0
