"""Child processes: fresh interpreters that run a function of a module on messages, and end with this process.

Nothing is forked: a copy of a process has the locks of threads that it does not have. A child knows what is sent to it
and nothing else that is loaded here. Its standard input is a pipe that only this process writes to: it ends when this
process does, however that ends, and the child ends with it. Standard output belongs to the answers alone; whatever else
prints goes to standard error, whose end is kept for messages about a child that was lost.

Why not multiprocessing: its children import the caller's main script again, and messages travel as pickles, which a
child that reads hostile files could forge.
"""

from __future__ import annotations

import importlib
import json
import os
import queue
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import IO

from stiffcal.module_path import child_environment, child_options, without_current_folder

# A child has so long to end by itself before it is killed, and its last messages so long to arrive, s.
STOP_S = 5.0
# A child whose end no pipe shows (a process that it started holds the pipe) is looked at so often, s.
_LOOK_S = 1.0
# Of standard error so much is kept, bytes.
_LAST_BYTES = 4000
# One that waits for its next request, and gets none for so long, ends, s: a notebook may stay open for days.
IDLE_S = 60.0
# A longer message is no message of ours, bytes.
MOST_BYTES = 1 << 30
_LENGTH = struct.Struct(">Q")
_NEW_GROUP = 0x200  # CREATE_NEW_PROCESS_GROUP of Windows
_ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
# The child finds stiffcal, and all else, where this process has found it; until then it takes nothing from the current
# folder.
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from stiffcal.processes import run_child; run_child(*sys.argv[2:])"
)

# Linux ends a child with the thread that has started it: this one lasts as long as the process.
_starter = ThreadPoolExecutor(max_workers=1, thread_name_prefix="start processes")


class ChildEndedError(Exception):
    """A child process ended before it answered; the text states how.

    Parameters
    ----------
    text : how it ended.
    status : its exit code, or minus the number of the signal that ended it; None where it has not ended.
    """

    def __init__(self, text: str, status: int | None = None) -> None:
        super().__init__(text)
        self.status = status


class ChildSilentError(Exception):
    """A child process sent nothing for the time that it was given."""


class ChildProcess:
    """A process that runs a function of a module. Used by one thread at a time.

    Parameters
    ----------
    function : of a module, by its name there; it takes a `Channel` and returns when it wants to end.
    memory_bytes : data that the process may hold, beyond which it gets no more; None: no limit. Only Linux keeps it.
    processor_s : processor time after which the system ends it, s; None: no limit. Not on Windows.
    """

    def __init__(
        self,
        function: Callable[[Channel], None],
        *,
        memory_bytes: int | None = None,
        processor_s: int | None = None,
    ) -> None:
        windows = sys.platform == "win32"
        # Of a group of its own: Ctrl-C in a terminal reaches the one who started it, who then stops it in order.
        self._process: subprocess.Popen[bytes] = _starter.submit(
            subprocess.Popen,
            [
                *(sys.executable, *child_options(), "-c", _START, json.dumps(without_current_folder(sys.path))),
                *(function.__module__, function.__qualname__, str(memory_bytes or ""), str(processor_s or "")),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**child_environment(), **_ONE_THREAD},
            process_group=None if windows else 0,
            creationflags=_NEW_GROUP if windows else 0,
        ).result()
        # Few wait: a child that sends much is held up until they are taken.
        self._messages: queue.Queue[bytes | None] = queue.Queue(maxsize=4)
        self._errors = b""
        self._readers = [_thread(self._read_messages), _thread(self._read_errors)]

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    @property
    def has_ended(self) -> bool:
        """Whether it has ended."""
        return self._process.poll() is not None

    def send(self, message: bytes) -> None:
        """Send a message; one that the process does not take is no reason to wait here."""
        _thread(self._write, message)

    def receive(self, timeout_s: float) -> bytes:
        """Return the next message of the process.

        Parameters
        ----------
        timeout_s : how long to wait for it, s.

        Raises
        ------
        ChildEndedError : it has ended, with its exit status and the last line of its standard error.
        ChildSilentError : nothing came in that time.
        """
        deadline, ended = time.monotonic() + timeout_s, False
        while True:
            left = deadline - time.monotonic()
            try:
                message = self._messages.get(timeout=max(min(left, _LOOK_S), 0.0))
            except queue.Empty:
                if ended:
                    raise self._how_it_ended() from None
                ended = self._process.poll() is not None
                if left <= 0.0 and not ended:
                    raise ChildSilentError(f"its process sent nothing for {timeout_s:g} s") from None
                continue
            if message is None:
                raise self._how_it_ended()
            return message

    def stop(self) -> None:
        """End the process and all of its group; one that does not end by itself is killed."""
        with suppress(OSError):
            self._process.terminate()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(STOP_S)
        self.kill()

    def kill(self) -> None:
        """End the process and all of its group at once: nothing that it holds has to be put in order."""
        if sys.platform != "win32":
            with suppress(OSError):
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.wait()
        # Messages that nobody takes any more hold up the thread that reads them.
        deadline = time.monotonic() + _LOOK_S
        while self._readers[0].is_alive() and time.monotonic() < deadline:
            with suppress(queue.Empty):
                self._messages.get(timeout=0.01)
        with suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.close()

    def _write(self, message: bytes) -> None:
        assert self._process.stdin is not None
        with suppress(OSError, ValueError):  # it has ended, which `receive` reports
            self._process.stdin.write(_LENGTH.pack(len(message)) + message)
            self._process.stdin.flush()

    def _read_messages(self) -> None:
        assert self._process.stdout is not None
        with suppress(OSError, ValueError), self._process.stdout as stream:
            while (message := _read_message(stream)) is not None:
                self._messages.put(message)
        self._messages.put(None)

    def _read_errors(self) -> None:
        assert self._process.stderr is not None
        with suppress(OSError, ValueError), self._process.stderr as stream:
            while written := os.read(stream.fileno(), 1 << 16):
                self._errors = (self._errors + written)[-_LAST_BYTES:]

    def _how_it_ended(self) -> ChildEndedError:
        try:
            code = self._process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            return ChildEndedError("its process stopped responding")
        # what it started may hold the other end for longer
        self._readers[1].join(_LOOK_S)
        # its end alone: of what a library or a campaign's code writes there the amount is unknown
        lines = self._errors.decode("utf-8", "replace").split("\n")
        message = next((line.strip() for line in reversed(lines) if line.strip()), "")
        ending = f"was ended by signal {-code}" if code < 0 else f"ended with code {code}"
        return ChildEndedError(f"its process {ending}" + (f": {message}" if message else ""), code)


class Channel:
    """A child process's end of the pipes to the process that started it.

    Parameters
    ----------
    requests : descriptor that messages are read from. answers : stream that messages are written to.
    """

    def __init__(self, requests: int, answers: IO[bytes]) -> None:
        self._answers = answers
        self._sending = threading.Lock()
        self._received: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        _thread(self._listen, requests)

    def requests(self, idle_s: float | None = None) -> Iterator[bytes]:
        """Yield messages as they come. There is no end: the process ends when nobody can send any more.

        Parameters
        ----------
        idle_s : it ends, too, when none came for so long, s; None: it waits.
        """
        while True:
            try:
                message = self._received.get(timeout=idle_s)
            except queue.Empty:
                os._exit(0)
            yield message

    def send(self, message: bytes) -> None:
        """Send a message; threads may do so at once.

        Raises
        ------
        BrokenPipeError : nobody receives it.
        """
        with self._sending:
            self._answers.write(_LENGTH.pack(len(message)) + message)
            self._answers.flush()

    def _listen(self, requests: int) -> None:
        """Hand on messages. When the sender is gone nobody wants an answer, and what is written is whole or absent."""
        # without a buffer of its own, whose lock the end of the interpreter would wait for
        with os.fdopen(requests, "rb", buffering=0) as stream, suppress(OSError):
            while (message := _read_message(stream)) is not None:
                self._received.put(message)
        os._exit(0)


def run_child(module: str, name: str, memory_bytes: str, processor_s: str) -> None:
    """Be the child process: run a module's function with the channel to the process that started this one."""
    if sys.platform == "linux":
        _end_with_parent()
    _limit(int(memory_bytes) if memory_bytes else None, int(processor_s) if processor_s else None)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # Whatever else reads or prints gets none of the messages, and gets nothing in between.
    requests, answers = os.dup(0), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    os.close(nothing)
    channel = Channel(requests, answers)
    try:
        getattr(importlib.import_module(module), name)(channel)
    except (KeyboardInterrupt, BrokenPipeError):
        # Asked to stop: what was being written has been taken away by now.
        os._exit(130)


def _end_with_parent() -> None:
    """Have the system kill this process with the one that started it, even where no line of Python can run."""
    import ctypes

    signal_at_end_of_parent = 1  # PR_SET_PDEATHSIG of the system's headers
    ctypes.CDLL(None).prctl(signal_at_end_of_parent, signal.SIGKILL)


def _limit(memory_bytes: int | None, processor_s: int | None) -> None:
    if sys.platform == "win32":
        return
    import resource

    # what a limit ends leaves no picture of its memory in the user's folder
    limits = {resource.RLIMIT_CORE: 0, resource.RLIMIT_DATA: memory_bytes, resource.RLIMIT_CPU: processor_s}
    for kind, most in limits.items():
        if most is not None:
            hard = resource.getrlimit(kind)[1]
            most = most if hard == resource.RLIM_INFINITY else min(most, hard)
            resource.setrlimit(kind, (most, most))


def _read_message(stream: IO[bytes]) -> bytes | None:
    """Return the next message of a stream; None at its end, or where something else than a message comes."""
    head = _read_bytes(stream, _LENGTH.size)
    if head is None:
        return None
    (length,) = _LENGTH.unpack(head)
    return _read_bytes(stream, length) if length <= MOST_BYTES else None


def _read_bytes(stream: IO[bytes], count: int) -> bytes | None:
    parts = []
    while count:
        part = stream.read(min(count, 1 << 20))
        if not part:
            return None
        parts.append(part)
        count -= len(part)
    return b"".join(parts)


def _thread(target: Callable[..., None], *values: object) -> threading.Thread:
    thread = threading.Thread(target=target, args=values, daemon=True)
    thread.start()
    return thread
