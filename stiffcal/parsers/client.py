"""Asking the child process that parses logs, and what became of it where it did not answer."""

from __future__ import annotations

import atexit
import os
import signal
import tempfile
import threading
import time
from collections.abc import Generator, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import (
    COLUMNS,
    LINE,
    MIB,
    PIECE,
    RATIO,
    ROWS,
    SECONDS,
    check_unpacked,
    most_unpacked,
    unpacked_exceeded,
)
from stiffcal.log_columns import Batch, Options, WantedColumns
from stiffcal.parsers.child import IDLE_S, serve
from stiffcal.parsers.messages import Allowance, Document, Request, batch_of, faults_of, parts_of
from stiffcal.processes import ChildEndedError, ChildProcess, ChildSilentError

READ_PER_S = 10e6
"""Bytes of a file for which a second is allowed until the next rows: a network of 100 Mbit/s has them."""
WORKED_PER_S = 50e3
"""Bytes for which a second is allowed in all: a message of a bag with a force takes 150 of them and 50 µs."""
FREE_MEMORY = 512 * MIB
"""Memory that the parser of any log may take, bytes: what libraries hold does not shrink with the file."""
SHARED_BY = 10
"""Processes that may have to share a processor: so many times as long as it may compute a parser may take."""
STARTING_S = 30.0
"""Until a process is there, its libraries loaded, and a disk that slept turns, s."""


@dataclass(frozen=True)
class LogHeader:
    """What a log states of itself."""

    columns: tuple[str, ...]
    units: dict[str, str]
    n_rows: int | None


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

    def header(self, wanted: WantedColumns | None) -> LogHeader:
        """Return what it states; with `wanted`, check that these columns are there."""
        with closing(self._answers(wanted, with_rows=False)) as answers:
            head, _ = next(answers)
        COLUMNS.check(len(head["columns"]), self.display_name)
        units = {str(name): str(unit) for name, unit in head["units"].items()}
        return LogHeader(tuple(map(str, head["columns"])), units, head["n_rows"])

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield its rows as they come.

        Raises
        ------
        InputError
            As the format's parser raises it; and where it takes more than is allowed, or ends the process.
        """
        size, sent = _size_of(self.path), 0
        with closing(self._answers(wanted, with_rows=True)) as answers:
            for head, rest in answers:
                batch = batch_of(head, rest)
                longest = {name: max(map(len, words), default=0) for name, words in head["words"].items()}
                for name, length in longest.items():
                    LINE.check(length, self.display_name, f"column {name}")
                sent += len(rest) + sum(longest.values())
                ROWS.check(batch.first_row - 1 + len(batch), self.display_name)
                check_unpacked(sent, size, self.display_name)
                yield batch

    def _answers(
        self, wanted: WantedColumns | None, *, with_rows: bool
    ) -> Generator[tuple[Document, memoryview], None, None]:
        """Yield the header, or batches of rows, as the child sends them."""
        allowance = _allowance(_size_of(self.path))
        with tempfile.TemporaryDirectory(prefix="stiffcal-") as scratch:
            request = Request(
                self.log_format, self.path, self.options, self.display_name, wanted, with_rows, allowance, scratch
            )
            child, is_sound = CHILDREN.take(), False
            try:
                child.send(request.message())
                while True:
                    head, rest = parts_of(self._received(child, allowance))
                    is_sound = head["kind"] not in ("batch", "memory")
                    if head["kind"] == "end":
                        return
                    if head["kind"] not in ("batch", "header"):
                        raise self._refusal(head, allowance)
                    yield head, rest
            finally:
                if is_sound:
                    CHILDREN.give_back(child)
                else:
                    child.stop()

    def _received(self, child: ChildProcess, allowance: Allowance) -> bytes:
        try:
            return child.receive(STARTING_S + SHARED_BY * allowance.silent_s)
        except ChildSilentError:
            raise self._too_long() from None
        except ChildEndedError as error:
            if error.status == -getattr(signal, "SIGXCPU", 0):
                raise self._too_long() from None
            if error.status == -getattr(signal, "SIGKILL", 0):
                raise PIECE.exceeded(self.display_name) from None
            reason, mend = f"the library that reads it failed ({error})", "copy it again from its origin, or log again"
            raise InputError.at(FaultCode.FILE_DAMAGED, self.display_name, "", reason, mend) from None

    def _too_long(self) -> InputError:
        mend = f"copy it again from its origin, or raise {SECONDS.variable}"
        return SECONDS.exceeded(self.display_name, "", mend)

    def _refusal(self, head: Document, allowance: Allowance) -> Exception:
        if head["kind"] == "fault":
            return faults_of(head)
        if head["kind"] == "memory":
            return (PIECE if allowance.memory == PIECE.most else RATIO).exceeded(self.display_name)
        if head["kind"] == "unpacked":
            return unpacked_exceeded(_size_of(self.path), self.display_name)
        return RuntimeError(f"in the process that parses logs:\n{head['text']}")


def _size_of(path: Path) -> int:
    """Return the bytes of a file, or of all files in a folder."""
    with suppress(OSError):
        files = path.iterdir() if path.is_dir() else (path,)
        return sum(file.stat().st_size for file in files)
    return 0


def _allowance(size: int) -> Allowance:
    """Return what the parsing of a file of so many bytes may take."""
    silent_s = SECONDS.most + size / READ_PER_S
    return Allowance(
        silent_s=silent_s,
        whole_s=silent_s + size / WORKED_PER_S,
        memory=min(PIECE.most, max(FREE_MEMORY, RATIO.most * size)),
        unpacked=most_unpacked(size),
    )


class _Children:
    """The processes that wait for a log, each with the moment since when."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._owner = os.getpid()
        self._waiting: list[tuple[float, ChildProcess]] = []

    def take(self) -> ChildProcess:
        """Return one that waits, or a new one."""
        while (found := self._pop()) is not None:
            since, child = found
            if not child.has_ended and time.monotonic() - since < IDLE_S / 2:
                return child
            child.stop()
        return ChildProcess(serve)

    def give_back(self, child: ChildProcess) -> None:
        """Keep one that is ready for the next log."""
        with self._lock:
            self._waiting.append((time.monotonic(), child))

    def stop_all(self) -> None:
        """End all that wait."""
        while (found := self._pop()) is not None:
            found[1].stop()

    def _pop(self) -> tuple[float, ChildProcess] | None:
        with self._lock:
            if self._owner != os.getpid():  # split off from another process, whose they are
                self._owner, self._waiting = os.getpid(), []
            return self._waiting.pop() if self._waiting else None


CHILDREN = _Children()
atexit.register(CHILDREN.stop_all)
