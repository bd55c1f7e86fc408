"""Asking a child process, and what became of it where it did not answer."""

from __future__ import annotations

import signal
import tempfile
from collections.abc import Generator
from dataclasses import dataclass

from stiffcal.bounded_work.child import serve
from stiffcal.bounded_work.messages import (
    END,
    FAULT,
    LAST,
    MEMORY,
    UNPACKED,
    Allowance,
    Document,
    Request,
    faults_of,
    parts_of,
)
from stiffcal.bounded_work.waiting import WaitingChildren
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import MIB, PIECE, RATIO, SECONDS, most_unpacked, unpacked_exceeded
from stiffcal.processes import ChildEndedError, ChildProcess, ChildSilentError

READ_PER_S = 10e6
"""Bytes of a file for which a second is allowed until the next answer: a network of 100 Mbit/s has them."""
WORKED_PER_S = 50e3
"""Bytes for which a second is allowed in all: a message of a bag with a force takes 150 of them and 50 µs."""
FREE_MEMORY = 512 * MIB
"""Memory that work on any file may take, bytes: what libraries hold does not shrink with the file."""
SHARED_BY = 10
"""Processes that may have to share a processor: so many times as long as it may compute work may take."""
STARTING_S = 30.0
"""Until a process is there, its libraries loaded, and a disk that slept turns, s."""


@dataclass(frozen=True)
class Work:
    """Work on a file, to be done in a child process.

    Attributes
    ----------
    module : the `Worker`. values : what it takes, as JSON has it.
    size : bytes of the file, after which what it may take is measured.
    display_name : how to call it in a fault. mend : what to do where it is damaged. place : where in it the fault is.
    """

    module: str
    values: Document
    size: int
    display_name: str
    mend: str
    place: str = ""

    def answers(self) -> Generator[tuple[Document, memoryview], None, None]:
        """Yield the documents and bytes of what the worker sends; to its end, or closed, which ends the process.

        Raises
        ------
        InputError
            As the worker raises it; and where the work takes more than is allowed, or ends the process.
        """
        allowance = _allowance(self.size)
        with tempfile.TemporaryDirectory(prefix="stiffcal-") as scratch:
            request = Request(self.module, self.values, self.display_name, allowance, scratch)
            child, is_sound = CHILDREN.take(), False
            try:
                child.send(request.message())
                while True:
                    head, rest = parts_of(self._received(child, allowance))
                    is_sound = head["kind"] in LAST
                    if head["kind"] == END:
                        return
                    if is_sound or head["kind"] == MEMORY:
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
                raise PIECE.exceeded(self.display_name, self.place) from None
            reason = f"the library that reads it failed ({error})"
            raise InputError.at(FaultCode.FILE_DAMAGED, self.display_name, self.place, reason, self.mend) from None

    def _too_long(self) -> InputError:
        return SECONDS.exceeded(self.display_name, self.place, f"{self.mend}, or raise {SECONDS.variable}")

    def _refusal(self, head: Document, allowance: Allowance) -> Exception:
        if head["kind"] == FAULT:
            return faults_of(head)
        if head["kind"] == MEMORY:
            return (PIECE if allowance.memory == PIECE.most else RATIO).exceeded(self.display_name, self.place)
        if head["kind"] == UNPACKED:
            return unpacked_exceeded(self.size, self.display_name, self.place)
        return RuntimeError(f"in a child process:\n{head['text']}")


def _allowance(size: int) -> Allowance:
    """Return what work on a file of so many bytes may take."""
    silent_s = SECONDS.most + size / READ_PER_S
    return Allowance(
        silent_s=silent_s,
        whole_s=silent_s + size / WORKED_PER_S,
        memory=min(PIECE.most, max(FREE_MEMORY, RATIO.most * size)),
        unpacked=most_unpacked(size),
    )


CHILDREN = WaitingChildren(serve)
