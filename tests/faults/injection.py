"""What goes wrong in a command under test: in its own process, at one of its dealings with the file system.

The process counts every opening, renaming, linking, making and removing (Python calls an audit hook for each before it
is done, C libraries apart), and at a chosen one the fault happens: the process is killed or interrupted, the disk is
full from there on, a right is revoked, a file is cut short.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
import random
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

CHANGES = frozenset({"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate"})
NEEDS_SPACE = frozenset({"os.mkdir", "os.link", "os.symlink"})
WRITING = os.O_WRONLY | os.O_RDWR
# CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, CAP_FOWNER: what lets root ignore permissions.
OVERRIDES = (1, 2, 3)
PR_CAPBSET_DROP = 24


class Watch:
    """Counts dealings with files below one folder, and lets the fault happen at the one that was chosen.

    Parameters
    ----------
    folder : dealings elsewhere (byte-code, libraries) do not count. at : the number of the chosen one, from 1.
    reads : count openings for reading too. happen : receives what it is that is about to be done; may raise.
    """

    def __init__(self, folder: str, at: int, reads: bool, happen: Callable[[str], None]) -> None:
        self.count = self.changes = 0
        self._folder, self._at, self._reads, self._happen = folder, at, reads, happen
        self._busy = False
        sys.addaudithook(self._hear)

    def _hear(self, event: str, given: tuple[Any, ...]) -> None:
        if self._busy or (event != "open" and event not in CHANGES):
            return
        writes = event != "open" or bool(given[2] & WRITING)
        if not (writes or self._reads) or not self._concerns(given):
            return
        self.count += 1
        self.changes += writes
        if self.count >= self._at:
            self._busy = True
            try:
                self._happen("write" if event == "open" and writes else event)
            finally:
                self._busy = False

    def _concerns(self, given: tuple[Any, ...]) -> bool:
        # Names inside a folder that is open come without it: those of shutil.rmtree.
        paths = [os.fspath(path) for path in given[:2] if isinstance(path, str | bytes | os.PathLike)]
        return any(self._folder in os.fsdecode(path) or not Path(os.fsdecode(path)).is_absolute() for path in paths)


def counted(folder: str) -> Watch:
    """Only count."""
    return Watch(folder, sys.maxsize, True, lambda event: None)


def killed(folder: str, at: int, how: int) -> Watch:
    """Send the process a signal; SIGKILL ends it before the dealing."""
    sent: list[str] = []

    def happen(event: str) -> None:
        if not sent:
            sent.append(event)
            os.kill(os.getpid(), how)

    return Watch(folder, at, False, happen)


def killed_after(seconds: float) -> None:
    """End the process after so long, wherever it is; nothing of it can catch that."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, seconds)


def full(folder: str, at: int) -> Watch:
    """Let the disk be full from there on: nothing can be made, what is there can be read, renamed and removed."""

    def happen(event: str) -> None:
        if event == "write" or event in NEEDS_SPACE:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    return Watch(folder, at, False, happen)


def cut_writes(size: int) -> None:
    """Let every file end at so many bytes, C libraries' too: what is written beyond is refused in the middle."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def revoked(folder: str, at: int, target: str, mode: int) -> Watch:
    """Take rights away from a file or folder, if it is there."""
    obey_permissions()

    def happen(event: str) -> None:
        with contextlib.suppress(FileNotFoundError):
            Path(target).chmod(mode)

    return Watch(folder, at, True, happen)


def truncated(folder: str, at: int, target: str, share: float) -> Watch:
    """Cut a file to a share of its length, if it is there, once."""
    done: list[str] = []

    def happen(event: str) -> None:
        with contextlib.suppress(FileNotFoundError):
            if not done:
                os.truncate(target, int(share * Path(target).stat().st_size))
            done.append(event)

    return Watch(folder, at, True, happen)


def later(seconds: float, act: Callable[[], object]) -> None:
    """Do something to others while the command runs."""

    def wait() -> None:
        time.sleep(seconds)
        act()

    threading.Thread(target=wait, daemon=True).start()


def kill_a_child(chance: random.Random) -> None:
    """Kill one of this process's children, if it has any."""
    me = str(os.getpid())
    children = [
        int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit() and _parent_of(entry) == me
    ]
    if children:
        os.kill(chance.choice(children), signal.SIGKILL)


def _parent_of(entry: Path) -> str:
    try:
        return (entry / "stat").read_text().rpartition(")")[2].split()[1]
    except OSError:
        return ""


def obey_permissions() -> None:
    """Have root obey permissions as everybody does; its children too."""
    if os.geteuid() != 0:
        return
    libc = ctypes.CDLL(None, use_errno=True)
    header = (ctypes.c_uint32 * 2)(0x20080522, 0)
    sets = (ctypes.c_uint32 * 6)()
    if libc.capget(header, sets):
        raise OSError(ctypes.get_errno(), "capget")
    for capability in OVERRIDES:
        libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)
        for kind in range(3):
            sets[kind] &= ~(1 << capability)
    if libc.capset(header, sets):
        raise OSError(ctypes.get_errno(), "capset")
