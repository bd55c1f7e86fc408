"""A plugin is code: its user is told before it runs for the first time, and again when it has changed.

What was told is remembered with the user, not in the campaign's store: a folder from someone else brings its own store
with it, and must not be able to say of itself that its code is known.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

_told: set[tuple[str, str]] = set()
_tellers: list[Callable[[str], None]] = []


def tell_by(teller: Callable[[str], None]) -> None:
    """Have the lines go to a function instead of standard error: of a process whose standard error nobody sees."""
    _tellers[:] = [teller]


def _tell(line: str) -> None:
    if _tellers:
        _tellers[0](line)
        return
    sys.stderr.write(line + "\n")
    sys.stderr.flush()


def memory_file() -> Path:
    """Return where it is remembered which plugins their user was told of."""
    if sys.platform == "win32":
        place = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    else:
        place = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return Path(place) / "stiffcal" / "plugins.json"


def announce(file: Path, content: bytes) -> str:
    """Say on standard error that a file is code and runs now, unless this very content was told of before.

    Parameters
    ----------
    file : the plugin. content : what of it is going to run.

    Returns
    -------
    The line that was said, "" where nothing was.
    """
    place, digest = str(file.resolve()), sha256(content).hexdigest()
    if (place, digest) in _told:
        return ""
    _told.add((place, digest))
    known = _remembered()
    if known.get(place) == digest:
        return ""
    change = "has changed since it last ran: it is" if place in known else "is"
    line = f"plugin {file} {change} code and runs now, with your rights (SHA-256 {digest[:12]}…)"
    _tell(line)
    _remember(known | {place: digest})
    return line


def _remembered() -> dict[str, str]:
    """Return plugin to hash; what cannot be read is told again."""
    try:
        found = json.loads(memory_file().read_text(encoding="utf-8"))
    except (OSError, ValueError, RuntimeError):
        return {}
    return found if isinstance(found, dict) else {}


def _remember(known: dict[str, str]) -> None:
    """Write it down where that can be; else it is told the next time again."""
    with suppress(OSError, RuntimeError):  # RuntimeError: there is no home folder
        goal = memory_file()
        goal.parent.mkdir(parents=True, exist_ok=True)
        beside = goal.with_name(f"{goal.name}.{os.getpid()}")
        beside.write_text(json.dumps(known, indent=1, sort_keys=True), encoding="utf-8")
        beside.replace(goal)
