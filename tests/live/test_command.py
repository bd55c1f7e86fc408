"""`stiffcal view --live` as a process: it names its address, serves it, and ends with the terminal."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import jsonschema
import pytest

SCHEMAS = Path(__file__).parents[2] / "schemas"


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is sent in another way there")
def test_the_page_is_served_until_it_is_interrupted(campaign: Path) -> None:
    words = [sys.executable, "-P", "-m", "stiffcal", "view", str(campaign), "--live", "--json"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
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
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=60)[1] == ""
        assert process.returncode == 0
