"""One command of stiffcal in a process of its own, and what it took."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

_CHILD = """
import json, os, resource, sys, time
raw = os.path.realpath(sys.argv[1]) + os.sep
opened = {}
def look(event, args):
    if event == "open" and isinstance(args[0], (str, bytes, os.PathLike)):
        path = os.path.realpath(os.fsdecode(args[0]))
        if path.startswith(raw):
            opened[path] = opened.get(path, 0) + 1
sys.addaudithook(look)
began = time.monotonic()
from stiffcal.cli.app import main
sys.argv = ["stiffcal", *sys.argv[2:]]
code = 0
try:
    main()
except SystemExit as end:
    code = end.code or 0
times, children = os.times(), resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps({
    "code": code, "seconds": time.monotonic() - began, "processor_s": sum(times[:4]),
    "peak_bytes": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
    "logs_opened": len(opened), "log_bytes": sum(os.path.getsize(path) for path in opened),
}), file=sys.stderr)
"""


@dataclass(frozen=True)
class Cost:
    """What a command took."""

    code: int
    """Its exit code."""
    processor_s: float
    """Seconds of processors, of its children too."""
    seconds: float
    """By the clock on the wall."""
    peak_bytes: int
    """Memory, at most."""
    logs_opened: int
    """Files below raw/ that it opened."""
    log_bytes: int
    """Their size together."""


def cost_of(folder: Path, *command: str) -> Cost:
    """Run a command on a campaign, and return what it took.

    Parameters
    ----------
    folder : the campaign. command : the command's name and further options; the folder follows the name.

    Raises
    ------
    RuntimeError : the command did not end by itself.
    """
    name, *options = command
    arguments = [sys.executable, "-c", _CHILD, str(folder / "raw"), name, str(folder), *options, "--json"]
    environment = dict(os.environ)
    if environment.pop("PYTHONDONTWRITEBYTECODE", ""):  # in an installation Python's compiled modules are there
        environment["PYTHONPYCACHEPREFIX"] = str(folder.parent / "compiled")
    ended = subprocess.run(arguments, capture_output=True, text=True, check=False, env=environment)
    lines = ended.stderr.strip().splitlines()
    try:
        return Cost(**json.loads(lines[-1]))
    except (IndexError, ValueError, TypeError):
        raise RuntimeError(f"{' '.join(command)}: {ended.stdout[-500:]} {ended.stderr[-500:]}") from None
