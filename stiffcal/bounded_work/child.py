"""The child process: one piece of work at a time, each within what it is allowed to take.

A library that reads damaged or hostile bytes may take any time or memory, or end the process; nothing inside it can be
called back. So the system holds the limits: more memory is refused, and a process that computes for too long is ended.
"""

from __future__ import annotations

import errno
import importlib
import math
import os
import sys
import tempfile
import time
import traceback
from contextlib import closing
from typing import cast

from stiffcal.bounded_work.messages import (
    END,
    INTERNAL,
    MEMORY,
    UNPACKED,
    Allowance,
    Request,
    Worker,
    fault_message,
    plain_message,
)
from stiffcal.errors import InputError
from stiffcal.files import refusal
from stiffcal.processes import IDLE_S, Channel

SENT_PER_S = 10e6
"""Bytes of answers for which a second is allowed: a tenth of what a slow computer unpacks."""


def serve(channel: Channel) -> None:
    """Do what is asked for, until nobody asks any more."""
    # An allocator of the library's own would take gigabytes of addresses at once.
    os.environ["ARROW_DEFAULT_MEMORY_POOL"] = "system"
    for message in channel.requests(IDLE_S):
        channel.send(_last_answer(channel, Request.of(message)))


def _last_answer(channel: Channel, request: Request) -> bytes:
    """Send what a worker answers; return the message that ends it."""
    try:
        worker = cast(Worker, importlib.import_module(request.module))
        worker.prepare(request.values)
        tempfile.tempdir = request.scratch
        with _Limits(request.allowance) as limits, closing(worker.answers(request.values)) as found:
            for message, unpacked in found:
                if unpacked > request.allowance.unpacked:
                    return plain_message(UNPACKED)
                channel.send(message)
                limits.renew(len(message))
    except InputError as error:
        return fault_message(error)
    except (MemoryError, SystemError):
        # a library in C that does not look whether it was given memory returns nothing, and names no error
        return plain_message(MEMORY)
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno == errno.EFBIG:
            return plain_message(UNPACKED)
        refused = refusal(error, request.display_name)
        return plain_message(INTERNAL, traceback.format_exc()) if refused is None else fault_message(refused)
    except Exception:
        return plain_message(INTERNAL, traceback.format_exc())
    return plain_message(END)


class _Limits:
    """Soft limits of this process, taken back for the next work: none on Windows, of memory on Linux alone."""

    def __init__(self, allowance: Allowance) -> None:
        self._allowance = allowance
        self._began, self._sent = time.process_time(), 0

    def __enter__(self) -> _Limits:
        if sys.platform != "win32":
            _set_soft(resource.RLIMIT_FSIZE, self._allowance.unpacked)
        if sys.platform == "linux":
            _set_soft(resource.RLIMIT_DATA, _data_bytes() + self._allowance.memory)
        self.renew(0)
        return self

    def renew(self, sent: int) -> None:
        """Allow the next stretch of processor time, after so many bytes of answers."""
        self._sent += sent
        next_rows = time.process_time() + self._allowance.silent_s
        whole = self._began + self._allowance.whole_s + self._sent / SENT_PER_S
        if sys.platform != "win32":
            _set_soft(resource.RLIMIT_CPU, math.ceil(min(next_rows, whole)))

    def __exit__(self, *ended_by: object) -> None:
        if sys.platform != "win32":
            for kind in (resource.RLIMIT_FSIZE, resource.RLIMIT_DATA, resource.RLIMIT_CPU):
                _set_soft(kind, resource.RLIM_INFINITY)


if sys.platform != "win32":
    import resource

    def _set_soft(kind: int, most: int) -> None:
        """Set a limit as far as the hard one allows it."""
        hard = resource.getrlimit(kind)[1]
        if hard != resource.RLIM_INFINITY and (most == resource.RLIM_INFINITY or most > hard):
            most = hard
        resource.setrlimit(kind, (most, hard))

    def _data_bytes() -> int:
        """Return the bytes of data that this process has now."""
        with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
            return int(file.read().split()[5]) * resource.getpagesize()
