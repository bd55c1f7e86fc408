"""`--verbose` and `--log-file FILE`: what a command does, on standard error and in a file; NO_COLOR and pipes."""

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
    assert run("identify", campaign, "--store", tmp_path / "store", "--log-file", log) == 0
    lines = log.read_text(encoding="utf-8").splitlines()
    assert all(LINE.fullmatch(line) for line in lines)
    assert f"identify {campaign}" in lines[0]
    assert any(" DEBUG " in line for line in lines[1:-1])
    assert " DEBUG " not in capsys.readouterr().err
    count = len(lines)
    assert run("effects", f"--log-file={log}") == 0  # appended
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
    assert run("identify", tmp_path / "nothing", "--verbose", "--log-file", log) == 2
    error = capsys.readouterr().err
    assert " ERROR " in log.read_text(encoding="utf-8")
    assert " ERROR " not in error
    assert len([line for line in error.splitlines() if not LINE.fullmatch(line)]) == 1


@pytest.mark.parametrize("words", ["--log-file", "--log-file=", "--log-file --json", "--log-file no/such/folder/a.log"])
def test_a_log_that_cannot_be_written_is_a_mistake_of_the_user(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("effects", *words.split()) == 2
    captured = capsys.readouterr()
    assert "--log-file" in captured.out + captured.err


def test_words_after_two_dashes_are_the_commands_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("check", "--", "--log-file") == 2  # a folder of this name, which there is not
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("content", [b"t,Fx\n0,1\n", b"\0", b"x" * 999, b"2026-01-01T00:00:00.000Z INFO version 1: s"])
def test_a_file_that_holds_no_log_is_left_alone(content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "sensor.csv"
    file.write_bytes(content)
    assert run("effects", "--log-file", file) == 2
    assert file.read_bytes() == content
    assert run("effects", "--log-file", file, "--force") == 0
    assert file.read_bytes().startswith(content)
    assert len(file.read_bytes()) > len(content)


def test_an_empty_file_becomes_a_log(tmp_path: Path) -> None:
    file = tmp_path / "a.log"
    file.touch()
    assert run("--log-file", file, "effects") == 0
    assert run("effects", "--log-file", file) == 0
    assert len(file.read_text(encoding="utf-8").splitlines()) == 4


def test_addresses_are_logged_without_their_passwords(tmp_path: Path) -> None:
    log = tmp_path / "a.log"
    run("check", tmp_path, "--store", "s3://key:geheim@bucket/store", "--log-file", log)
    assert "geheim" not in log.read_text(encoding="utf-8")


@pytest.mark.skipif(sys.platform != "linux", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("no_colour", [False, True])
def test_no_color_and_pipes_are_respected(no_colour: bool) -> None:
    environment = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR")}
    environment |= {"TERM": "xterm-256color"} | ({"NO_COLOR": "1"} if no_colour else {})
    command = [sys.executable, "-P", "-m", "stiffcal", "effects", "backlash"]
    if not no_colour:
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
