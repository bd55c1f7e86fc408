"""A campaign that brings code along: the effect of the documentation, in a file that leaves a mark when it runs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.laboratory.documentation import ROOT, plugin_of_the_documentation
from tests.laboratory.small_campaign import write_small_campaign

NAME = "cross_stiffness.py"
NEEDED = '\n[[effects]]\ntype = "cross-stiffness"\njoints = [2]\n'
MARK = "\nfrom pathlib import Path\nPath(__file__).with_name('ran').touch()\n"


def stranger(folder: Path, needed: bool = True, further: str = MARK) -> Path:
    """A campaign folder with a plugin, which its model needs or not."""
    write_small_campaign(folder)
    write_plugin(folder, further)
    list_plugins(folder, NAME)
    if needed:
        with (folder / "model.toml").open("a", encoding="utf-8") as model:
            model.write(NEEDED)
    return folder


def write_plugin(folder: Path, further: str = "", name: str = NAME) -> None:
    (folder / name).write_text(plugin_of_the_documentation() + further, encoding="utf-8")


def list_plugins(folder: Path, *names: str) -> None:
    manifest = folder / "campaign.toml"
    lines = [line for line in manifest.read_text(encoding="utf-8").splitlines() if not line.startswith("plugins")]
    listed = ", ".join(f'"{name}"' for name in names)
    manifest.write_text("\n".join([f"plugins = [{listed}]", *lines]) + "\n", encoding="utf-8")


def ran(folder: Path) -> bool:
    """Whether the plugin has run since the last time this was asked."""
    mark = folder / "ran"
    found = mark.exists()
    mark.unlink(missing_ok=True)
    return found


def stiffcal(*words: str | Path, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own, as `stiffcal` does."""
    command = [sys.executable, "-P", "-m", "stiffcal", *map(str, words)]
    path = str(ROOT)
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": path, **environment},
        stdin=subprocess.DEVNULL,
        timeout=120,
    )
