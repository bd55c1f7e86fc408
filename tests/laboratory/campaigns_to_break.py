"""Copies of practice campaigns, to be broken one way each."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

PRACTICE = Path(__file__).resolve().parents[3] / "shared" / "practice"
needs_practice = pytest.mark.skipif(not PRACTICE.is_dir(), reason="the folder of practice campaigns is not here")


def copied(name: str, to: Path) -> Path:
    """Copy a practice campaign so that it can be written to."""
    folder = to / name
    shutil.copytree(PRACTICE / name, folder)
    for path in [folder, *folder.rglob("*")]:
        path.chmod(0o755 if path.is_dir() else 0o644)
    return folder


def one_run(to: Path) -> Path:
    """Return 13-raw with its first run alone."""
    folder = copied("13-raw", to)
    text = (folder / "campaign.toml").read_text()
    second = text.index("[[runs]]", text.index("[[runs]]") + 1)
    (folder / "campaign.toml").write_text(text[:second])
    return folder


def edit(path: Path, *changes: tuple[str, str]) -> None:
    """Replace pieces of a file, each of which has to be there."""
    text = path.read_text(encoding="latin-1")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="latin-1")


def edit_table(folder: Path, change: Callable[[list[str], list[list[str]]], None]) -> None:
    """Change header and rows of the table of states."""
    path = folder / "raw" / "states.csv"
    lines = [line.split(",") for line in path.read_text().splitlines()]
    header, rows = lines[0], lines[1:]
    change(header, rows)
    path.write_text("\n".join(",".join(line) for line in [header, *rows]) + "\n")
