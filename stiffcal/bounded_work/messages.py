"""Messages between stiffcal and a child process: a line of JSON, and behind it arrays as they are.

Why not pickles: what has parsed a stranger's file must not be able to make objects here.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode

Document: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class Allowance:
    """What work on one file may take."""

    silent_s: float
    """Processor time until the first answer, and from one to the next, s."""
    whole_s: float
    """Processor time in all, s; more for what is sent."""
    memory: int
    """Memory beyond what the process has at the beginning, bytes."""
    unpacked: int
    """Bytes once unpacked: of the largest temporary file, and of all that is counted."""


class Worker(Protocol):
    """A module that works in the child process."""

    def prepare(self, values: Document) -> None:
        """Import the libraries that the work takes: what they take is not the file's doing."""

    def answers(self, values: Document) -> Generator[tuple[bytes, int], None, None]:
        """Yield messages made by `joined`, of other kinds than those below, and the bytes unpacked up to each.

        Raises
        ------
        InputError
            A fault of the file.
        """


@dataclass(frozen=True)
class Request:
    """What is to be done."""

    module: str
    """The `Worker`."""
    values: Document
    """What it takes."""
    display_name: str
    """The file as messages name it."""
    allowance: Allowance
    scratch: str
    """A folder for temporary files."""

    def message(self) -> bytes:
        """Return it as a message."""
        return joined(
            {
                "module": self.module,
                "values": self.values,
                "name": self.display_name,
                "allowance": vars(self.allowance),
                "scratch": self.scratch,
            }
        )

    @classmethod
    def of(cls, message: bytes) -> Request:
        """Return the request of a message."""
        given, _ = parts_of(message)
        return cls(given["module"], given["values"], given["name"], Allowance(**given["allowance"]), given["scratch"])


END, FAULT, UNPACKED, INTERNAL, MEMORY = "end", "fault", "unpacked", "internal", "memory"
LAST = (END, FAULT, UNPACKED, INTERNAL)
"""Kinds of messages with which work ends, and the process is ready for other work."""


def fault_message(error: InputError) -> bytes:
    """Return the message of faults in a file."""
    faults = [{**fault.as_document(), "names": fault.names, "rows": fault.rows} for fault in error.faults]
    return joined({"kind": FAULT, "faults": faults})


def faults_of(head: Document) -> InputError:
    """Return the faults of a message."""
    return InputError(
        *(
            Fault(
                **{
                    **fault,
                    "code": FaultCode(fault["code"]),
                    "names": tuple(fault["names"]),
                    "rows": tuple(fault["rows"]),
                }
            )
            for fault in head["faults"]
        )
    )


def plain_message(kind: str, text: str = "") -> bytes:
    """Return a message of one word, or of `INTERNAL` with the text of an exception."""
    return joined({"kind": kind, "text": text})


def parts_of(packet: bytes) -> tuple[Document, memoryview]:
    """Return a message's document, and the bytes behind it."""
    end = packet.index(b"\n")
    return json.loads(packet[:end]), memoryview(packet)[end + 1 :]


def joined(head: Document, arrays: Sequence[NDArray[Any] | bytes] = ()) -> bytes:
    """Return a message of a document and the bytes of arrays."""
    pieces = (array.tobytes() if isinstance(array, np.ndarray) else array for array in arrays)
    return b"".join([json.dumps(head).encode(), b"\n", *pieces])
