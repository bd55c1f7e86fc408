"""What a folder from a stranger must leave alone: files outside it, other programs, the network.

An audit hook, which Python asks before it opens, makes, renames, links or removes a file, starts a program or connects.
It cannot be taken off again, so it is set once in a process and asks whether there is a fence at present.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from stiffcal.bounded_work.child import serve

SECRET = "fuzz-secret-7f3a"
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
CHANGES = frozenset({
    "os.rename", "os.link", "os.symlink", "os.remove", "os.mkdir", "os.rmdir", "os.truncate", "os.chmod", "os.chown",
    "os.utime", "shutil.rmtree", "shutil.move", "shutil.copyfile",
})  # fmt: skip
FORBIDDEN = frozenset({
    "socket.connect", "socket.getaddrinfo", "socket.bind", "subprocess.Popen", "os.system", "os.exec",
    "os.posix_spawn",
})  # fmt: skip

PARSES = [serve.__module__, serve.__qualname__, "", ""]
"""The last arguments of stiffcal's own child process, with a folder for its temporary files."""
SCRATCH = os.path.realpath(Path(tempfile.gettempdir(), "stiffcal-"))


class BrokenFenceError(BaseException):
    """Something outside was touched; no `except Exception` may hide it."""


class Fence:
    """What is allowed at present.

    Attributes
    ----------
    inside : folders that may be written to, None where there is no fence.
    forbidden : a folder of which nothing may be opened.
    """

    def __init__(self) -> None:
        self.inside: tuple[str, ...] | None = None
        self.forbidden = ""
        self._set = False

    @contextmanager
    def around(self, inside: tuple[Path, ...], forbidden: Path) -> Iterator[None]:
        """Hold the fence inside the block, and compare the forbidden folder before and after it."""
        if not self._set:
            sys.dont_write_bytecode = True
            sys.addaudithook(self._hear)
            self._set = True
        before = _state_of(forbidden)
        self.inside, self.forbidden = tuple(os.path.realpath(path) for path in inside), os.path.realpath(forbidden)
        try:
            yield
        finally:
            self.inside = None
        if _state_of(forbidden) != before:
            raise BrokenFenceError(f"{forbidden} has changed")

    def _hear(self, event: str, given: tuple[Any, ...]) -> None:
        if self.inside is None:
            return
        if event == "subprocess.Popen" and given[0] == "fc-list":
            return  # by which matplotlib finds the fonts of the system
        if event == "subprocess.Popen" and given[1][-len(PARSES) :] == PARSES:
            return  # in which files are parsed
        if event in FORBIDDEN:
            raise self._broken(f"{event} {given!r}"[:300])
        if event == "open":
            path, _, flags = given
            self._judge(event, path, bool(flags & WRITING))
        elif event in CHANGES:
            ends_at = 2 if event in ("os.rename", "os.link", "shutil.move") else 1
            for path in given[1:2] if event == "os.symlink" else given[:ends_at]:
                self._judge(event, path, True)

    def _judge(self, event: str, path: object, writes: bool) -> None:
        """Judge a whole path; a bare name is one inside a folder that was opened, and that was judged."""
        if not isinstance(path, str | bytes | os.PathLike):
            return
        name = os.fsdecode(path)
        if not Path(name).is_absolute() or name == os.devnull:
            return
        # of what is removed or renamed the name counts, not what a link of that name leads to
        where = Path(os.path.realpath(Path(name).parent), Path(name).name)
        real = os.path.realpath(name) if event == "open" else str(where)
        assert self.inside is not None
        if _lies_in(real, self.forbidden):
            raise self._broken(f"{event} of {name}")
        if writes and not real.startswith(SCRATCH) and not any(_lies_in(real, folder) for folder in self.inside):
            raise self._broken(f"{event} writes to {name}")

    def _broken(self, words: str) -> BrokenFenceError:
        self.inside = None  # what reports it may open files
        return BrokenFenceError(words)


def _lies_in(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder + os.sep)


def _state_of(folder: Path) -> list[tuple[str, int, int, int]]:
    return sorted(
        (str(path), found.st_nlink, found.st_size, found.st_mtime_ns)
        for path in (folder, *folder.rglob("*"))
        for found in (path.lstat(),)
    )


FENCE = Fence()
