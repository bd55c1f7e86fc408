"""Which logs of a campaign somebody still writes: looked at again and again, never opened for longer than a moment."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from stiffcal.campaign.toml.reach import leads_outside
from stiffcal.errors import InputError
from stiffcal.files import open_regular

SETTLED_S = 1.0
"""A log in which nothing has changed for so long is read: loggers that write line by line write many a second."""
QUIET_S = 5.0
"""What is wrong with a log is reported once nothing has changed for so long. A logger that collects what it writes
does so in blocks of 4096 bytes (stdio): at ten rows of 80 bytes a second one comes every five seconds.
"""
_TAIL = 4
"""Bytes at the end of a text in which its last line ends: two in UTF-16, and a carriage return before them."""


class Stage(Enum):
    """How far a log is."""

    ABSENT = "not there yet"
    GROWING = "still written"
    CUT = "its last line has no end yet"
    SETTLED = "settled"
    QUIET = "quiet"
    """Settled for so long that it is reported what is wrong with it."""


@dataclass(frozen=True)
class Log:
    """A log at a look."""

    stage: Stage
    stamp: tuple[int, int] = (0, 0)
    """Its size and the time of its last change, ns: another one, other rows."""
    cut: bool = False
    """Whether its last line has no end; once it is quiet, the reader decides whether a needed cell may be cut."""

    @property
    def is_readable(self) -> bool:
        """Whether it is read now."""
        return self.stage in (Stage.SETTLED, Stage.QUIET)


class LogFiles:
    """The logs of a campaign from look to look.

    Parameters
    ----------
    folder : of the campaign.
    clock, wall : seconds; the first never goes back, the second counts from 1970 as the times of files do.
    """

    def __init__(
        self, folder: Path, clock: Callable[[], float] = time.monotonic, wall: Callable[[], float] = time.time
    ) -> None:
        self._folder, self._clock, self._wall = folder, clock, wall
        self._since: dict[str, tuple[tuple[int, int], float]] = {}

    def look(self, files: Iterable[tuple[str, bool]]) -> Mapping[str, Log]:
        """Return every log as it is now.

        Parameters
        ----------
        files : each relative to the folder, and whether it is text of lines.
        """
        return {file: self._log(file, is_text) for file, is_text in files}

    def _log(self, file: str, is_text: bool) -> Log:
        path = self._folder / file
        try:
            status = None if leads_outside(self._folder, file) is not None else path.stat()
        except (OSError, ValueError):
            status = None
        if status is None or not stat.S_ISREG(status.st_mode) or not status.st_size:
            self._since.pop(file, None)
            return Log(Stage.ABSENT)
        stamp, now = (status.st_size, status.st_mtime_ns), self._clock()
        known = self._since.get(file)
        if known is None or known[0] != stamp:
            # a log that was there before has been still since its last change; one that changes under our eyes has not
            age = max(self._wall() - status.st_mtime, 0.0) if known is None else 0.0
            known = self._since[file] = (stamp, now - age)
        still = now - known[1]
        cut = is_text and self._is_cut(path)
        if still < SETTLED_S:
            return Log(Stage.GROWING, stamp, cut)
        if cut and still < QUIET_S:
            return Log(Stage.CUT, stamp, cut)
        return Log(Stage.QUIET if still >= QUIET_S else Stage.SETTLED, stamp, cut)

    def _is_cut(self, path: Path) -> bool:
        try:
            with open_regular(path, buffering=0) as opened:
                opened.seek(-min(_TAIL, path.stat().st_size), os.SEEK_END)
                tail = opened.read(_TAIL)
        except (OSError, InputError):
            return False  # reading it reports why
        return tail.rstrip(b"\0")[-1:] not in (b"\n", b"\r")
