"""The child process that parses logs: one at a time, each within what it is allowed to take.

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
import threading
import time
import traceback
from contextlib import suppress
from typing import TYPE_CHECKING

from stiffcal.errors import InputError
from stiffcal.files import refusal
from stiffcal.parsers.messages import (
    Allowance,
    Request,
    batch_message,
    fault_message,
    header_message,
    plain_message,
)
from stiffcal.processes import Channel

if TYPE_CHECKING:
    from stiffcal.parsers.open_log import Parser

IDLE_S = 60.0
"""A process that is asked for nothing so long ends, s: a notebook may stay open for days."""
SENT_PER_S = 10e6
"""Bytes of rows for which a second is allowed: a tenth of what a slow computer unpacks."""


def serve(channel: Channel) -> None:
    """Parse what is asked for, until nobody asks any more."""
    # An allocator of the library's own would take gigabytes of addresses at once.
    os.environ["ARROW_DEFAULT_MEMORY_POOL"] = "system"
    requests = channel.requests()
    while True:
        idle = threading.Timer(IDLE_S, os._exit, [0])
        idle.daemon = True
        idle.start()
        message = next(requests)
        idle.cancel()
        channel.send(_last_answer(channel, Request.of(message)))


def _last_answer(channel: Channel, request: Request) -> bytes:
    """Send what a log holds; return the message that ends it."""
    try:
        module = importlib.import_module(f"stiffcal.parsers.{request.log_format}")
        open_log: Parser = module.open_log
        # what the format's library takes to be imported is not the log's doing
        for library in getattr(module, "LIBRARIES", ()):
            with suppress(ImportError):
                importlib.import_module(library)
        tempfile.tempdir = request.scratch
        with (
            _Limits(request.allowance) as limits,
            open_log(request.path, request.options, request.display_name) as log,
        ):
            if request.wanted is not None:
                log.check(request.wanted)
            if log.unpacked > request.allowance.unpacked:
                return plain_message("unpacked")
            if request.wanted is None or not request.with_rows:
                return header_message(log.columns, log.units, log.n_rows)
            for batch in log.batches(request.wanted):
                if log.unpacked > request.allowance.unpacked:
                    return plain_message("unpacked")
                rows = batch_message(batch)
                channel.send(rows)
                limits.renew(len(rows))
    except InputError as error:
        return fault_message(error)
    except MemoryError:
        return plain_message("memory")
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno == errno.EFBIG:
            return plain_message("unpacked")
        refused = refusal(error, request.display_name)
        return plain_message("internal", traceback.format_exc()) if refused is None else fault_message(refused)
    except Exception:
        return plain_message("internal", traceback.format_exc())
    return plain_message("end")


class _Limits:
    """Soft limits of this process, which are taken back for the next log: none on Windows, of memory on Linux alone."""

    def __init__(self, allowance: Allowance) -> None:
        self._allowance = allowance
        self._began, self._sent = time.process_time(), 0

    def __enter__(self) -> _Limits:
        if sys.platform != "win32":
            _set_soft(resource.RLIMIT_CORE, 0)
            _set_soft(resource.RLIMIT_FSIZE, self._allowance.unpacked)
        if sys.platform == "linux":
            _set_soft(resource.RLIMIT_DATA, _data_bytes() + self._allowance.memory)
        self.renew(0)
        return self

    def renew(self, sent: int) -> None:
        """Allow the next stretch of processor time, after so many bytes of rows."""
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
