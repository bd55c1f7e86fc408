"""Follow `next:` lines from a state of a campaign until they end; what two ways share is done once."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import re
import shlex
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import typer

from stiffcal.cli.app import main
from stiffcal.cli.command_tree import command_named
from stiffcal.commands.history import read_history
from stiffcal.commands.standing import standing_of
from stiffcal.errors import InputError
from stiffcal.results.history_results import HistoryResult
from stiffcal.stages.steps import RunContext
from tests.laboratory.offered_toml import faults_in

Words = tuple[str, ...]
NEXT = "next: "
# A command at the end of a line, of what comes later or of a fault's mend; without an option it may begin a sentence.
_PRINTED = re.compile(r"(?:(?<!next): stiffcal|; stiffcal(?=.* --)) (.+?)(?: \[[a-z-]+\])?$", re.MULTILINE)
# Longer than the loop with an improvement, a new effect and all pictures.
MOST_STEPS = 15
DONE = (0, 1)


@dataclass(frozen=True)
class Answered:
    """What a command answered in a state."""

    code: int
    following: Words | None
    """Of its `next:` line; None where it has none."""
    state: str
    """Of the campaign after it."""
    error: str
    """Standard error."""
    refused: tuple[str, ...] = ()
    """What it offers to be pasted and none of our files, or of our commands, takes."""


@dataclass
class Walker:
    """Runs commands in copies of campaign folders."""

    work: Path
    """A folder for the copies."""
    answers: dict[tuple[str, Words], Answered] = field(default_factory=dict)
    """By state and command."""
    _kept: dict[str, Path] = field(default_factory=dict)

    def begin(self, folder: Path) -> str:
        """Return the state of a campaign folder, which is kept."""
        state = state_of(folder)
        if state not in self._kept:
            self._kept[state] = self._copy(folder)
        return state

    def follow(self, state: str, words: Words) -> Iterator[str]:
        """Yield what is wrong on the way from a command on: a step that does not run, or a state that comes again."""
        been: list[tuple[str, Words]] = []
        while True:
            if (state, words) in been:
                yield f"comes back to: {_way(been, words)}"
                return
            if len(been) > MOST_STEPS:
                yield f"does not end: {_way(been, words)}"
                return
            answered = self.answer(state, words)
            # the first command is the user's; the others were proposed, `check` to name what is wrong with the logs
            if been and answered.code not in ((*DONE, 2) if words[0] == "check" else DONE):
                yield f"exit code {answered.code}: {_way(been, words)}: {answered.error.strip()[-300:]}"
            yield from (f"cannot be pasted: {_way(been, words)}: {piece}" for piece in answered.refused)
            been.append((state, words))
            if answered.following is None:
                return
            state, words = answered.state, answered.following

    def answer(self, state: str, words: Words) -> Answered:
        """Run a command in a state, or return what it answered there before."""
        if (state, words) not in self.answers:
            folder = self._copy(self._kept[state])
            code, out, error = run(folder, words)
            after = state_of(folder)
            if after not in self._kept:
                self._kept[after] = folder
            wrong = tuple(fault for text in (out, error) for fault in (*faults_in(text), *refused_commands(text)))
            self.answers[state, words] = Answered(code, next_words(out, error), after, error, wrong)
        return self.answers[state, words]

    def _copy(self, folder: Path) -> Path:
        """Return a copy; its name is the same for all, as a campaign without a name takes its folder's."""
        place = self.work / f"{len(list(self.work.iterdir())):04d}" / "campaign"
        shutil.copytree(folder, place)
        return place


def run(folder: Path, words: Sequence[str]) -> tuple[int, str, str]:
    """Run `stiffcal` with the folder as the current one; return its exit code and what it printed on both streams."""
    out, error, here = io.StringIO(), io.StringIO(), Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            main(list(words))
    except SystemExit as ended:
        return int(ended.code or 0), out.getvalue(), error.getvalue()
    finally:
        os.chdir(here)
    raise AssertionError("stiffcal ends with its exit code")


def next_words(out: str, error: str) -> Words | None:
    """Return the command of the last `next:` line, without `stiffcal`; None where there is none."""
    lines = [line for text in (error, out) for line in text.splitlines() if line.startswith(NEXT)]
    return tuple(shlex.split(lines[-1].removeprefix(NEXT))[1:]) if lines else None


def refused_commands(text: str) -> Iterator[str]:
    """Yield the printed commands that the command line does not read, and why."""
    for line in _PRINTED.findall(text):
        try:
            name, *words = shlex.split(line)
            command_named(name).make_context(name, words)
        except (typer.TyperException, ValueError) as error:
            yield f"{line!r}: {error}"


def state_of(folder: Path) -> str:
    """Return a hash of what a person wrote and measured, and of what is known of the model; not of pictures."""
    parts: list[object] = []
    for file in sorted(folder.rglob("*")):
        name = file.relative_to(folder).as_posix()
        if file.is_file() and not name.startswith("store/") and file.suffix in (".toml", ".py", ".csv", ".mat", ".h5"):
            parts += [name, hashlib.sha256(file.read_bytes()).hexdigest()]
    context = RunContext(update=False)
    try:
        history: HistoryResult = read_history(folder, context)
        parts += [[(fit.id, fit.heldout_rms is None) for fit in history.fits], standing_of(folder, context)]
    except InputError as error:
        parts.append(error.code)
    parts.append((folder / "store").exists())
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _way(been: Sequence[tuple[str, Words]], words: Words) -> str:
    return " → ".join(shlex.join(step) for step in [*(step for _, step in been), words])
