"""Where modules are taken from: never from the current folder, which may be a campaign of somebody else.

A file `json.py` in a delivered folder must not run because a command is started in it. Python itself puts the current
folder on its path for ``python -m`` and ``python -c`` (unless ``-P`` is given), and for every empty entry of
``PYTHONPATH``, which ``PYTHONPATH=$PYTHONPATH:/my/modules`` makes where it was not set before. A folder that the user
names is the user's choice and stays.

And what libraries do on their own in a process of ours: no warnings, no windows.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

_PACKAGES = str(Path(__file__).resolve().parents[1])
"""The folder that this package lies in."""


def without_current_folder(path: Sequence[str]) -> list[str]:
    """Return a module path without the entries that stand for the current folder, whichever that is.

    Examples
    --------
    >>> without_current_folder(["", "/usr/lib/python3", "."])[:1]
    ['/usr/lib/python3']
    """
    kept = [entry for entry in path if entry not in ("", os.curdir)]
    return kept if len(kept) == len(path) or _PACKAGES in kept else [*kept, _PACKAGES]


def leave_out_current_folder(started_by_name: bool = False) -> None:
    """Take the current folder off this process's module path, where only Python's start has put it there.

    Parameters
    ----------
    started_by_name : True where this is ``python -m stiffcal``, for which Python puts it first.
    """
    python_path = os.environ.get("PYTHONPATH", "")
    first = started_by_name and not sys.flags.safe_path
    empty = bool(python_path) and "" in python_path.split(os.pathsep) and not sys.flags.ignore_environment
    current_folder = _current()
    if (first or empty) and current_folder not in (_PACKAGES, ""):
        chosen = {os.path.realpath(entry) for entry in python_path.split(os.pathsep) if entry}
        if current_folder not in chosen:
            sys.path[:] = [entry for entry in sys.path if entry and os.path.realpath(entry) != current_folder]
    sys.path[:] = without_current_folder(sys.path)


def child_environment() -> dict[str, str]:
    """Return the environment for a child process of Python: nothing in it adds the current folder to its path."""
    environment = {**os.environ, "PYTHONSAFEPATH": "1"}
    python_path = environment.pop("PYTHONPATH", "")
    kept = [entry for entry in python_path.split(os.pathsep) if entry]
    return {**environment, "PYTHONPATH": os.pathsep.join(kept)} if kept else environment


def child_options() -> list[str]:
    """Return the options for a child process of Python: as strict as this one, and without the current folder."""
    options = (("-I", sys.flags.isolated), ("-E", sys.flags.ignore_environment), ("-s", sys.flags.no_user_site))
    return ["-P", *(option for option, is_set in options if is_set)]


def quiet_libraries() -> None:
    """Keep the warnings of libraries from standard error, whatever PYTHONWARNINGS asks for; ``--debug`` shows them.

    They name lines of code, not the user's files; where one matters the command reports it itself.
    """
    warnings.simplefilter("ignore")
    os.environ["MPLBACKEND"] = "agg"  # pictures are files, and a backend that is not installed ends matplotlib's import


def _current() -> str:
    try:
        return str(Path.cwd().resolve())
    except OSError:  # it has been deleted: nothing can be taken from it
        return ""
