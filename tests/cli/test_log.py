"""`--verbose` and `--log FILE`: what a command does, on standard error and in a file; NO_COLOR and pipes."""

from __future__ import annotations

import logging
import os
import pty
import re
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from stiffcal.cli.app import main
from stiffcal.cli.log import taken_out

LINE = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z (DEBUG|INFO|WARNING|ERROR) \S.*")


def run(*words: str | Path) -> int:
    """Run stiffcal in this process, and return its exit code."""
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    assert isinstance(end.value.code, int)
    return end.value.code


def test_a_log_holds_the_command_its_steps_and_its_end(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "stiffcal.log"
    assert run("identify", campaign, "--store", tmp_path / "store", "--log", log) == 0
    lines = log.read_text(encoding="utf-8").splitlines()
    assert all(LINE.fullmatch(line) for line in lines)
    assert f"identify {campaign}" in lines[0]
    assert any(" DEBUG " in line for line in lines[1:-1])
    assert " DEBUG " not in capsys.readouterr().err
    count = len(lines)
    assert run("effects", f"--log={log}") == 0  # appended
    assert len(log.read_text(encoding="utf-8").splitlines()) == count + 2
    assert not logging.getLogger("stiffcal").handlers


def test_verbose_leaves_standard_output_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("effects", "--json") == 0
    plain = capsys.readouterr()
    assert run("effects", "--json", "--verbose") == 0
    verbose = capsys.readouterr()
    assert verbose.out == plain.out
    assert plain.err == ""
    assert len([line for line in verbose.err.splitlines() if LINE.fullmatch(line)]) == 2


def test_a_mistake_is_logged_and_printed_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "a.log"
    assert run("identify", tmp_path / "nothing", "--verbose", "--log", log) == 2
    error = capsys.readouterr().err
    assert " ERROR " in log.read_text(encoding="utf-8")
    assert " ERROR " not in error
    assert len([line for line in error.splitlines() if not LINE.fullmatch(line)]) == 1


@pytest.mark.parametrize("words", [["--log"], ["--log="], ["--log", "--json"], ["--log", "no/such/folder/a.log"]])
def test_a_log_that_cannot_be_written_is_a_mistake_of_the_user(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("effects", *words) == 2
    captured = capsys.readouterr()
    assert "--log" in captured.out + captured.err


def test_words_after_two_dashes_are_the_commands_own() -> None:
    assert taken_out(["check", "--", "--verbose", "--log", "x"]) == (
        ["check", "--", "--verbose", "--log", "x"],
        False,
        None,
    )


def test_addresses_are_logged_without_their_passwords(tmp_path: Path) -> None:
    log = tmp_path / "a.log"
    run("check", tmp_path, "--store", "s3://key:geheim@bucket/store", "--log", log)
    assert "geheim" not in log.read_text(encoding="utf-8")


@pytest.mark.skipif(sys.platform != "linux", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("no_colour", [False, True])
def test_no_color_and_pipes_are_respected(no_colour: bool) -> None:
    environment = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR")}
    environment |= {"TERM": "xterm-256color"} | ({"NO_COLOR": "1"} if no_colour else {})
    command = [sys.executable, "-P", "-m", "stiffcal", "effects", "backlash"]
    piped = subprocess.run(command, capture_output=True, env=environment, check=True).stdout
    assert b"\x1b[" not in piped
    parent, child = pty.openpty()
    with subprocess.Popen(command, stdout=child, stderr=child, env=environment):
        os.close(child)
        written = b""
        with suppress(OSError):  # raised at the end: the other side is closed
            while chunk := os.read(parent, 65536):
                written += chunk
    os.close(parent)
    coloured = re.findall(rb"\x1b\[(?:\d+;)*(?:3[0-9]|9[0-7]|38;[0-9;]+)m", written)
    assert not (no_colour and coloured)
    assert written
