"""The wheel that `make dist` builds, without the repository: it holds all that commands need."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from importlib import import_module
from pathlib import Path

import pytest

from stiffcal.propose.templates import template_kinds

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, unpacked as an installer does it."""
    place, before = tmp_path_factory.mktemp("wheel"), Path.cwd()
    os.chdir(ROOT)
    try:
        name = import_module("flit_core.buildapi").build_wheel(str(place))
    finally:
        os.chdir(before)
    with zipfile.ZipFile(place / name) as wheel:
        wheel.extractall(place / "packages")
    return place / "packages"


def run(unpacked: Path, folder: Path, *words: str) -> str:
    """Run a command of the wheel in a folder; the libraries are those of this environment.

    Without `site` no *.pth file leads to the repository.
    """
    shared = [entry for entry in sys.path if entry and Path(entry).resolve() != ROOT]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(unpacked), *shared])}
    code = f"import stiffcal; assert stiffcal.__file__.startswith({str(unpacked)!r}), stiffcal.__file__"
    subprocess.run([sys.executable, "-PS", "-c", code], cwd=folder, env=environment, check=True)
    command = [sys.executable, "-PS", "-m", "stiffcal", *words]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_holds_what_commands_need(unpacked: Path, tmp_path: Path) -> None:
    for kind in template_kinds():
        run(unpacked, tmp_path, "init", kind, "--kind", kind)
    run(unpacked, tmp_path, "simulate", "twin", "--from", str(unpacked / "stiffcal" / "workflow" / "example"))
    assert (tmp_path / "twin" / "truth.json").is_file()


@pytest.mark.long
def test_the_demo_of_the_wheel_runs(unpacked: Path, tmp_path: Path) -> None:
    run(unpacked, tmp_path, "demo")
    assert (tmp_path / "demo" / "report.pdf").is_file()
    assert (tmp_path / "demo" / "view.html").is_file()
