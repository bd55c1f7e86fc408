"""Run the commands of one revision on the bundled campaigns and write down what they answer."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from tests.answers.compare import ROUNDED
from tests.answers.variants import SUBSET, VARIANTS

PACKED = re.compile(r'<script type="text/plain" id="data">([^<]*)</script>')
REPOSITORY = Path(__file__).resolve().parents[2]
WIDTHS = (80, 120)
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

STEPS: dict[str, tuple[str, ...]] = {
    "check": ("check", "."),
    "ingest": ("ingest", "."),
    "identify": ("identify", "."),
    "validate": ("validate", "."),
    "diagnose": ("diagnose", "."),
    "history": ("history", "."),
    "map": ("map", ".", "--load", "0,0,-500"),
    "export-states": ("export", ".", "-o", "answer-states.csv"),
    "export-model": ("export", ".", "-o", "answer-model.json"),
    "view": ("view", ".", "-o", "answer.html"),
    "report": ("report", ".", "-o", "answer.pdf"),
    "improve": ("improve", ".", "--yes"),
}
"""Each with ``--json``, in this order: later ones find the store of the earlier ones."""
IN_WORDS = ("check", "identify", "validate", "diagnose", "history")
FILES = ("answer-states.csv", "answer-model.json", "model.toml")


@dataclass(frozen=True)
class Revision:
    """A revision of stiffcal that can be run.

    Attributes
    ----------
    code : its checkout. state : the folder of the user's state that its commands use.
    """

    code: Path
    state: Path

    def run(self, words: Sequence[str], place: Path, width: int | None = None) -> tuple[int, str, str]:
        """Run a command; return exit code, standard output and standard error.

        Parameters
        ----------
        words : the command's. place : the current folder. width : of the terminal that is played; None: a pipe.
        """
        environment = {
            **os.environ,
            **ONE_THREAD,
            "PYTHONPATH": str(self.code),
            "STIFFCAL_STATE": str(self.state),
            "XDG_STATE_HOME": str(self.state),
            "NO_COLOR": "1",
            "TERM": "xterm",
        }
        call = [sys.executable, "-P", "-m", "stiffcal", *words]
        if width is not None:
            environment["COLUMNS"] = str(width)
            call = [sys.executable, "-P", str(Path(__file__).with_name("terminal.py")), *call]
        ended = subprocess.run(
            call, cwd=place, env=environment, stdin=subprocess.DEVNULL, capture_output=True, check=False
        )
        return ended.returncode, ended.stdout.decode("utf-8", "replace"), ended.stderr.decode("utf-8", "replace")


def record(
    revision: str, folder: Path, campaigns: str | None, only: Sequence[str] | None, workers: int, subset: bool = False
) -> None:
    """Record what a revision answers.

    Parameters
    ----------
    revision : as git knows it. folder : where the answers go; made anew.
    campaigns : the revision whose campaigns are asked; None: the same.
    only : beginnings of the names of the campaigns that are asked; None: all. workers : how many at a time.
    subset : ask one campaign of each kind alone.
    """
    folder = folder.resolve()
    shutil.rmtree(folder, ignore_errors=True)
    code = check_out(revision, folder / "code")
    source = code if campaigns is None else check_out(campaigns, folder / "campaigns")
    there = Revision(code, folder / "state")
    _check_runs(there)
    answers = folder / "answers"
    _write(answers / "schemas.txt", "\n".join(sorted(path.name for path in (code / "schemas").glob("*.json"))))
    for path in (code / "schemas").glob("*.json"):
        _write(answers / "schemas" / path.name, path.read_text("utf-8"))
    _general(there, folder, answers / "general")
    written = folder / "variants"
    for name, write in VARIANTS.items():
        write(source / "campaigns", written / name)
    places = {
        path.parent.relative_to(root).as_posix(): path.parent
        for root in (source / "campaigns", written)
        for path in sorted(root.glob("**/campaign.toml"))
    }
    chosen = [
        name
        for name in places
        if (only is None or any(name.startswith(start) for start in only)) and (not subset or name in SUBSET)
    ]
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(lambda name: _campaign(there, places[name], folder, Path(name)), chosen))


def _check_runs(there: Revision) -> None:
    """Raise where this Python runs another stiffcal than the revision's, as an editable install may."""
    environment = {**os.environ, "PYTHONPATH": str(there.code)}
    where = [sys.executable, "-P", "-c", "import stiffcal; print(stiffcal.__file__)"]
    found = subprocess.run(where, env=environment, capture_output=True, text=True, check=True).stdout.strip()
    if not Path(found).is_relative_to(there.code):
        raise RuntimeError(
            f"this Python runs {found} whatever PYTHONPATH is: use one in which stiffcal is not installed"
        )


def check_out(revision: str, goal: Path) -> Path:
    """Write the files of a revision to a folder, and return it."""
    packed = subprocess.run(["git", "archive", revision], cwd=REPOSITORY, capture_output=True, check=True).stdout
    with tarfile.open(fileobj=BytesIO(packed)) as archive:
        archive.extractall(goal, filter="data")
    return goal


def _general(there: Revision, folder: Path, answers: Path) -> None:
    """Record what needs no campaign: the help pages and the catalogue of effects."""
    code, listing, _ = there.run(["--help"], folder)
    _write(answers / "help.txt", listing)
    commands = subprocess.run(
        [sys.executable, "-P", "-c", "from stiffcal.cli.app import COMMANDS; print(*COMMANDS)"],
        env={**os.environ, "PYTHONPATH": str(there.code)},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    for command in commands:
        for width in WIDTHS:
            _write(answers / f"help-{command}-{width}.txt", there.run([command, "--help"], folder, width)[1])
    _write(answers / "effects.json", there.run(["effects", "--json"], folder)[1])
    _write(answers / "effects.txt", there.run(["effects"], folder, WIDTHS[0])[1])
    for path in sorted((there.code / "stiffcal" / "effects").glob("[a-z]*.py")):
        name = path.stem.replace("_", "-")
        _write(answers / f"effects-{name}.txt", there.run(["effects", name], folder, WIDTHS[0])[1])
    if code != 0:
        raise RuntimeError(f"--help ends with {code}")


def _campaign(there: Revision, source: Path, folder: Path, name: Path) -> None:
    place, answers = folder / "work" / name, folder / "answers" / "campaigns" / name
    if (source / "simulate.toml").exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        words = ["simulate", str(place), "--from", str(source), "--json"]
        _write_answer(answers / "simulate.json", there.run(words, folder))
    if not place.exists():
        # where nothing was simulated the folder stands for itself; `..` may lead to logs of a folder next to it
        shutil.copytree(source, place)
    for step, step_words in STEPS.items():
        if step == "improve":
            for command in IN_WORDS:
                for width in WIDTHS:
                    _write(answers / f"{command}-{width}.txt", there.run([command, "."], place, width)[1])
        _write_answer(answers / f"{step}.json", there.run([*step_words, "--json"], place))
    for file in FILES:
        if (place / file).exists():
            _write(answers / file, (place / file).read_text("utf-8"))
    if (place / "answer.html").exists():
        _write(answers / "view-data.json", _data_of(place / "answer.html"))
    if (place / "answer.pdf").exists():
        _write(answers / "report.txt", _text_of(place / "answer.pdf"))
    print(f"recorded {name.as_posix()}", flush=True)


def _text_of(pdf: Path) -> str:
    from pypdf import PdfReader

    return "\n\f\n".join(page.extract_text() for page in PdfReader(pdf).pages)


def _data_of(page: Path) -> str:
    """Return what is packed into a page of `view`: arrays in place of references, with the step they are rounded to."""
    from stiffcal.view.packing import unpacked

    packed = PACKED.search(page.read_text("utf-8"))
    if packed is None:
        raise ValueError(f"{page.name}: no data in the page")
    document, arrays = unpacked(packed[1])

    def filled(value: Any) -> Any:
        if isinstance(value, list):
            return [filled(item) for item in value]
        if not isinstance(value, dict):
            return value
        if "$" in value:
            reference = value["$"]
            values = arrays[reference["at"]] if reference["n"] else np.zeros(0)
            return {ROUNDED: reference["step"], "values": values.tolist()}
        return {key: filled(item) for key, item in value.items()}

    return json.dumps(filled(document), ensure_ascii=False)


def _write_answer(path: Path, ended: tuple[int, str, str]) -> None:
    """Write an answer's document, and next to it the exit code and what stood on standard error."""
    code, document, remarks = ended
    _write(path, document)
    _write(path.with_suffix(".end.txt"), f"exit code {code}\n{remarks}")


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")
