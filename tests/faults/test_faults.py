"""Faults at random points of the commands that write; a few here, hundreds with ``make faults``."""

from __future__ import annotations

import errno
import os
import random
import sys
from pathlib import Path

import pytest

from stiffcal.cli.app import COMMANDS as ALL_COMMANDS
from tests.faults.__main__ import bench, kinds_of, table_of
from tests.faults.commands import COMMANDS
from tests.faults.trials import KINDS, FoundError, Outcome

TRIES = int(os.environ.get("STIFFCAL_FAULTS", str(len(KINDS))))
# Each way of writing once: the store in several steps, the user's own file, a file of results by a C library.
CHOSEN = ("ingest again", "run from nothing", "add", "export parquet", "init --from")
# Commands that write nothing, or only what another one here writes.
WRITE_NOTHING = {"check", "compare", "doctor", "trend"}
MADE_OF_OTHERS = {"run", "demo"}

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc, flock and prctl are of Linux")


def test_nothing_is_lost(capsys: pytest.CaptureFixture[str]) -> None:
    chance = random.Random(7)
    light = [command for command in COMMANDS if command.name in CHOSEN]
    outcomes: list[Outcome] = []
    found: list[str] = []
    with bench(light) as on:
        commands = [chance.choice(light) for _ in range(TRIES)]
        for number, command in enumerate(commands):
            kind = KINDS[number % len(KINDS)]
            try:
                outcomes.append(on.try_once(command, kind, chance))
            except FoundError as error:
                found.append(str(error))
    with capsys.disabled():
        print("\n" + table_of(outcomes, found))
    assert not found, "\n".join(found)
    assert {one.kind for one in outcomes} == set(KINDS)


def test_every_command_that_writes_is_tried() -> None:
    tried = {command.words[0] for command in COMMANDS}
    assert tried | WRITE_NOTHING | MADE_OF_OTHERS == set(ALL_COMMANDS)
    assert all(kinds_of(command) for command in COMMANDS)


def test_what_the_system_refuses_is_no_internal_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from stiffcal.cli.app import main

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "somewhere")

    monkeypatch.setattr("stiffcal.commands.history.read_history", refuse)
    with pytest.raises(SystemExit) as end:
        main(["history", str(tmp_path)])
    assert end.value.code == 2
    reason = "cannot be read or written: No space left on device"
    mend = "free some space, or choose another disk"
    assert capsys.readouterr().err == f"somewhere: {reason}; {mend} [system-refusal]\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full is of Linux")
def test_an_answer_that_cannot_be_written(capfd: pytest.CaptureFixture[str]) -> None:
    import subprocess

    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "stiffcal", "effects"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("standard output: cannot be read or written: No space left on device; free some")
