"""Runs the commands of a page in a folder with a copy of `campaigns/`, and keeps what they printed and drew.

`make docs` takes the pictures of a page from such a run, the tests compare the output. A run is kept under a key of the
page's commands, of stiffcal's code and of the campaigns: what has not changed is not run again.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from docs.page_blocks import Block, blocks_of, pictures_of

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "build" / "docs" / "runs"
PLACE = "STIFFCAL_DOCS_RUNS"
"""Environment variable with the folder in which runs are kept, in place of build/docs/runs."""
AS_SHOWN = "STIFFCAL_DOCS_AS_SHOWN"
"""Environment variable: where it is set, no command runs; a page has printed what it shows, its pictures are blank."""
PIXELS_PER_POINT = 1.6
BLANK_SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="1600" height="900"/>'
MADE_BY_STIFFCAL = shutil.ignore_patterns("store", "report.pdf", "view.html", "__pycache__")


class PageError(Exception):
    """A command of a page failed, or a picture was not made."""


@dataclass(frozen=True)
class PageRun:
    """What the commands of one page did."""

    printed: dict[int, str]
    """Line of a block on the page to what its commands printed."""
    pictures: dict[tuple[str, int], Path]
    """(file, page) to the picture."""


def run_page(page: str, pictures_alone: bool = False) -> PageRun:
    """Return what the commands of a page print and draw; they run only where no run of them is kept.

    Parameters
    ----------
    page : its name relative to docs/.
    pictures_alone : whether only what the page draws is wanted: blocks after its last picture then do not run.

    Raises
    ------
    PageError : a command failed, or a picture was not made.
    """
    place = Path(os.environ.get(PLACE) or KEPT)
    folder = place / page.removesuffix(".md").replace("/", "-")
    folder.mkdir(parents=True, exist_ok=True)
    if os.environ.get(AS_SHOWN):
        return _as_shown(page, folder)
    key = _key(page)
    with _locked(folder):
        record = folder / "printed.json"
        kept = json.loads(record.read_text(encoding="utf-8")) if record.exists() else {}
        if kept.get("key") != key or not (pictures_alone or kept.get("whole")):
            record.unlink(missing_ok=True)
            printed = _run(page, folder, pictures_alone)
            is_whole = all(block.line in printed for block in blocks_of(page) if block.tag == "run")
            record.write_text(json.dumps({"key": key, "printed": printed, "whole": is_whole}), encoding="utf-8")
        stored = json.loads(record.read_text(encoding="utf-8"))["printed"]
    pictures = {wanted: folder / picture_name(*wanted) for wanted in pictures_of(page)}
    return PageRun({int(line): text for line, text in stored.items()}, pictures)


def _as_shown(page: str, folder: Path) -> PageRun:
    """Return a run that printed what the page shows and drew blank pictures, which stand in `folder`."""
    printed: dict[int, str] = {}
    last = 0
    for block in blocks_of(page):
        if block.tag == "run":
            last = block.line
            printed[last] = ""
        elif block.tag == "output":
            printed[last] = block.text
    pictures = {wanted: folder / f"blank-{picture_name(*wanted)}" for wanted in pictures_of(page)}
    for place in pictures.values():
        if place.suffix == ".svg":
            place.write_text(BLANK_SVG, encoding="utf-8")
        else:
            from PIL import Image

            Image.new("1", (1600, 900), 1).save(place)
    return PageRun(printed, pictures)


def picture_name(file: str, page: int) -> str:
    """Return the name under which a picture is kept."""
    stem, _, ending = file.replace("/", "-").rpartition(".")
    return f"{stem}-page{page}.png" if page else f"{stem}.{ending}"


def _run(page: str, kept: Path, pictures_alone: bool) -> dict[int, str]:
    """Run the blocks of a page in order, in one folder, all or until its pictures are there; keep these in `kept`."""
    printed: dict[int, str] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(ROOT / "campaigns", folder / "campaigns", ignore=MADE_BY_STIFFCAL)
        printed |= _run_cells([block for block in blocks_of(page) if is_cell(block)], folder)
        for block in blocks_of(page):
            if pictures_alone and all((folder / file).is_file() for file, _ in pictures_of(page)):
                break
            if block.tag == "run" and not is_cell(block):
                printed[block.line] = _run_block(block, folder)
            elif block.tag == "file":
                (folder / block.reason).write_text(block.text, encoding="utf-8")
        for file, number in pictures_of(page):
            if not (folder / file).is_file():
                raise PageError(f"{page}: no command makes the picture {file}")
            _keep(folder / file, number, kept / picture_name(file, number))
    return printed


def is_cell(block: Block) -> bool:
    """Return whether a block is a cell of a notebook: Python that runs with what the cells before it have left."""
    return (block.language, block.tag) == ("python", "run")


def _run_cells(cells: list[Block], folder: Path) -> dict[int, str]:
    """Run the cells of a page in one process, before its commands; return what each prints, by its line."""
    if not cells:
        return {}
    words = [sys.executable, "-P", str(Path(__file__).with_name("cells.py"))]
    printed = json.loads(_printed_by(words, folder, cells[0], json.dumps([cell.text for cell in cells])))
    return {cell.line: text for cell, text in zip(cells, printed, strict=True)}


def _run_block(block: Block, folder: Path) -> str:
    """Run the commands of one block; return what they print."""
    return _printed_by(["bash", "-euo", "pipefail", "-c", block.text], folder, block)


def _printed_by(words: list[str], folder: Path, block: Block, given: str = "") -> str:
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    settings = {"PATH": path, "COLUMNS": "100", "NO_COLOR": "1", "STIFFCAL_STATE": str(folder / ".state")}
    environment = {**os.environ, **settings}
    done = subprocess.run(words, cwd=folder, env=environment, input=given, capture_output=True, text=True)
    if done.returncode:
        raise PageError(f"{block.page}:{block.line}: {done.stdout}{done.stderr}")
    return done.stdout


def _keep(file: Path, number: int, place: Path) -> None:
    """Copy a picture, or draw one page of a PDF."""
    if not number:
        shutil.copyfile(file, place)
        return
    import pypdfium2

    document = pypdfium2.PdfDocument(file)
    try:
        document[number - 1].render(scale=PIXELS_PER_POINT).to_pil().save(place, optimize=True)
    finally:
        document.close()


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the folder of a page: another process waits."""
    with (folder / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _key(page: str) -> str:
    """Return the digest of all that a run of the page depends on."""
    parts = [digest_of_code(), *(block.text for block in blocks_of(page) if block.tag in ("run", "file"))]
    parts += [f"{file} {number}" for file, number in pictures_of(page)]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@cache
def digest_of_code() -> str:
    """Return the digest of stiffcal's code and of the bundled campaigns."""
    digest = hashlib.sha256()
    made = {"store", "__pycache__"}
    for folder in ("stiffcal", "campaigns"):
        for file in sorted((ROOT / folder).rglob("*")):
            parts = file.relative_to(ROOT).parts
            if file.is_file() and not made.intersection(parts) and file.name not in {"report.pdf", "view.html"}:
                digest.update(f"{parts}".encode())
                digest.update(file.read_bytes())
    return digest.hexdigest()
