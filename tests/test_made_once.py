"""What is made once in a session: `tests.laboratory.once`."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.laboratory import once as module
from tests.laboratory.once import folder_once, once

CALLS = "STIFFCAL_TESTS_CALLS"


def doubled(number: int) -> list[int]:
    with Path(os.environ[CALLS]).open("a", encoding="utf-8") as file:
        file.write(f"{number}\n")
    return [2 * number]


def fill(folder: Path, text: str) -> None:
    doubled(0)
    (folder / "a").write_text(text, encoding="utf-8")
    if not text:
        raise ValueError("no text")


@pytest.fixture
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "shared").mkdir()
    monkeypatch.setenv(module.PLACE, str(tmp_path / "shared"))
    monkeypatch.setenv(CALLS, str(tmp_path / "calls"))
    return tmp_path / "calls"


def test_each_caller_gets_a_copy_of_what_was_made_once(calls: Path) -> None:
    first = once(doubled, 3)
    first.append(0)
    assert once(doubled, 3) == [6]
    assert once(doubled, 4) == [8]
    assert calls.read_text("utf-8").split() == ["3", "4"]


def test_processes_share_it(calls: Path) -> None:
    code = "from tests.test_made_once import doubled, once; print(once(doubled, 5))"
    root = Path(__file__).parents[1]
    running = [subprocess.Popen([sys.executable, "-c", code], cwd=root, stdout=subprocess.PIPE) for _ in range(2)]
    assert [process.communicate()[0].split() for process in running] == [[b"[10]"]] * 2
    assert calls.read_text("utf-8").split() == ["5"]


def test_a_folder_whose_maker_failed_is_made_anew(calls: Path) -> None:
    with pytest.raises(ValueError, match="no text"):
        folder_once(fill, "")
    with pytest.raises(ValueError, match="no text"):
        folder_once(fill, "")
    assert (folder_once(fill, "x") / "a").read_text("utf-8") == "x"
    assert folder_once(fill, "x") == folder_once(fill, "x")
    assert len(calls.read_text("utf-8").split()) == 3
