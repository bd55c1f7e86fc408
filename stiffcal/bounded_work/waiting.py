"""Child processes of one kind that wait for the next work, so that it need not wait for theirs to start."""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections.abc import Callable

from stiffcal.processes import IDLE_S, Channel, ChildProcess


class WaitingChildren:
    """The processes that wait for work, each with the moment since when.

    Parameters
    ----------
    function : what they run; it takes its requests within `IDLE_S`.
    memory_bytes : as of `ChildProcess`.
    """

    def __init__(self, function: Callable[[Channel], None], memory_bytes: int | None = None) -> None:
        self._function, self._memory_bytes = function, memory_bytes
        self._lock = threading.Lock()
        self._owner = os.getpid()
        self._waiting: list[tuple[float, ChildProcess]] = []
        atexit.register(self.stop_all)

    def take(self) -> ChildProcess:
        """Return one that waits, or a new one."""
        while (found := self._pop()) is not None:
            since, child = found
            if not child.has_ended and time.monotonic() - since < IDLE_S / 2:
                return child
            child.stop()
        return self._new()

    def start_early(self) -> None:
        """Start a process that is needed soon, so that it starts while this one does something else."""
        with self._lock:
            needed = self._owner == os.getpid() and not self._waiting
        if needed:
            self.give_back(self._new())

    def give_back(self, child: ChildProcess) -> None:
        """Keep one that is ready for the next work."""
        with self._lock:
            self._waiting.append((time.monotonic(), child))

    def stop_all(self) -> None:
        """End all that wait."""
        while (found := self._pop()) is not None:
            found[1].stop()

    def _new(self) -> ChildProcess:
        return ChildProcess(self._function, memory_bytes=self._memory_bytes)

    def _pop(self) -> tuple[float, ChildProcess] | None:
        with self._lock:
            if self._owner != os.getpid():  # split off from another process, whose they are
                self._owner, self._waiting = os.getpid(), []
            return self._waiting.pop() if self._waiting else None
