"""A plugin is code: said before it runs for the first time and when it has changed, with the answer unharmed."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from stiffcal.model import plugin_notice
from tests.workflow.campaigns_to_break import edit

README = Path(__file__).parents[2] / "README.md"
NOTICE = "is code and runs now, with your rights (SHA-256 "


def effects(folder: Path, state: Path) -> subprocess.CompletedProcess[str]:
    """Run a command that loads the plugin, in a process of its own, and give back what it said."""
    command = [sys.executable, "-m", "stiffcal", "add", str(folder), "cross-stiffness", "--joints", "2", "--json"]
    environment = {"XDG_STATE_HOME": str(state), "LOCALAPPDATA": str(state), "PYTHONPATH": str(README.parent)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    return done


MODEL = 'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = "all"\n'


@pytest.fixture
def folder(campaign: Path) -> Path:
    """A campaign with the README's plugin, which prints while it is loaded."""
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    (text,) = (block for block in blocks if "class CrossStiffness" in block)
    (campaign / "cross_stiffness.py").write_text(text + '\nprint("hello from the plugin")\n', encoding="utf-8")
    edit(campaign / "campaign.toml", ('robot = "robot.toml"', 'robot = "robot.toml"\nplugins = ["cross_stiffness.py"]'))
    (campaign / "model.toml").write_text(MODEL, encoding="utf-8")
    return campaign


def test_it_is_said_once_and_after_a_change(folder: Path, tmp_path: Path) -> None:
    state = tmp_path / "state"
    first = effects(folder, state)
    assert first.returncode == 0, first.stderr
    assert json.loads(first.stdout)["changes"]
    (line,) = (line for line in first.stderr.splitlines() if NOTICE in line)
    assert "cross_stiffness.py" in line
    assert "hello from the plugin" in first.stderr
    assert first.stderr.index(NOTICE) < first.stderr.index("hello")
    assert NOTICE not in effects(folder, state).stderr
    with (folder / "cross_stiffness.py").open("a") as file:
        file.write("# one line more\n")
    changed = effects(folder, state)
    assert f"has changed since it last ran: it {NOTICE}" in changed.stderr
    assert json.loads(changed.stdout)["changes"]


def test_a_batch_says_it_too(folder: Path, tmp_path: Path) -> None:
    environment = {name: str(tmp_path / "state") for name in ("XDG_STATE_HOME", "LOCALAPPDATA")}
    command = [sys.executable, "-m", "stiffcal", "batch", str(folder), "--no-report", "--json"]
    environment["PYTHONPATH"] = str(README.parent)
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    (line,) = (line for line in done.stderr.splitlines() if NOTICE in line)
    assert "cross_stiffness.py" in line
    assert json.loads(done.stdout)["counts"]["held"] == 1


def test_what_cannot_be_remembered_is_said_each_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "state").write_text("a file where a folder should be")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    for _ in range(2):
        monkeypatch.setattr(plugin_notice, "_told", set())
        assert plugin_notice.announce(tmp_path / "own.py", b"1") in capsys.readouterr().err
    assert plugin_notice.announce(tmp_path / "own.py", b"1") == ""


def test_a_campaigns_own_store_does_not_speak_for_its_plugin(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "someone"))
    assert not plugin_notice.memory_file().resolve().is_relative_to(folder.resolve())
