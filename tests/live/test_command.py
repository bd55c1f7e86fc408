"""`stiffcal view --live` as a process: it names its address, serves it, and ends with the terminal."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import jsonschema
import pytest

SCHEMAS = Path(__file__).parents[2] / "schemas"


@contextmanager
def as_at_a_terminal(number: signal.Signals) -> Iterator[None]:
    """Have a child begin with a signal as a terminal's children do: ``nohup`` and ``&`` hand down an ignored one."""
    before = signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(number, before)


@contextmanager
def ended_at_last(process: subprocess.Popen[str]) -> Iterator[None]:
    """End a process that a test has failed to end: to leave it would wait for ever."""
    try:
        yield
    finally:
        process.kill()


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is sent in another way there")
@pytest.mark.parametrize(("option", "number"), [("--live", "SIGINT"), ("--watch", "SIGHUP")])
def test_the_page_is_served_until_it_is_interrupted(campaign: Path, tmp_path: Path, option: str, number: str) -> None:
    words = [sys.executable, "-P", "-m", "stiffcal", "view", str(campaign), option, "--json"]
    place = tmp_path / "temporary"
    place.mkdir()
    own = {**os.environ, "TMPDIR": str(place)}
    with (
        as_at_a_terminal(getattr(signal, number)),
        subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=own) as process,
        ended_at_last(process),
    ):
        assert process.stdout is not None
        decoder, text = json.JSONDecoder(), ""
        while True:
            line = process.stdout.readline()
            assert line, process.communicate()[1]
            text += line
            try:
                document, _ = decoder.raw_decode(text)
            except ValueError:
                continue
            break
        schema = json.loads((SCHEMAS / "live.document.schema.json").read_text())
        jsonschema.Draft202012Validator(schema).validate(document)
        with urllib.request.urlopen(document["address"], timeout=60) as answer:
            assert b"stiffcal view" in answer.read()
        process.send_signal(getattr(signal, number))
        assert process.communicate(timeout=60)[1] == ""
        assert process.returncode == 0
    assert list(place.iterdir()) == []  # what was read of the logs goes with the server
