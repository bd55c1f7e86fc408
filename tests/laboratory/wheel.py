"""The wheel that `make dist` builds, unpacked, and its commands run without the repository."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).parents[2]


def unpack_wheel(place: Path) -> None:
    """Build the wheel into a folder that exists, and unpack it there as an installer does it."""
    before = Path.cwd()
    os.chdir(ROOT)
    try:
        name = import_module("flit_core.buildapi").build_wheel(str(place))
    finally:
        os.chdir(before)
    with zipfile.ZipFile(place / name) as wheel:
        wheel.extractall(place / "packages")


def run(packages: Path, folder: Path, *words: str) -> str:
    """Run a command of the wheel in a folder; the libraries are those of this environment.

    Without `site` no *.pth file leads to the repository.
    """
    shared = [entry for entry in sys.path if entry and Path(entry).resolve() != ROOT]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(packages), *shared])}
    code = f"import stiffcal; assert stiffcal.__file__.startswith({str(packages)!r}), stiffcal.__file__"
    subprocess.run([sys.executable, "-PS", "-c", code], cwd=folder, env=environment, check=True)
    command = [sys.executable, "-PS", "-m", "stiffcal", *words]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return done.stdout
