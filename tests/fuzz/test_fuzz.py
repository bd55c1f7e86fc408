"""A few inputs of every target, bounded in time; ``make fuzz`` feeds ten thousand of each."""

from __future__ import annotations

import socket
import subprocess
from pathlib import Path

import pytest

from stiffcal.cli.app import main
from stiffcal.fault_codes import FaultCode
from tests.fuzz.feeding import PATIENCE_S, feed, feed_one
from tests.fuzz.fence import FENCE, BrokenFenceError
from tests.fuzz.targets import formats_not_fed, targets
from tests.laboratory.campaign_folders import write_campaign

COUNT, SECONDS = 200, 6.0


def test_every_format_is_fed() -> None:
    assert formats_not_fed() == ()


@pytest.mark.parametrize("name", [name for name in targets() if name not in PATIENCE_S])
def test_refused_or_accepted(name: str, request: pytest.FixtureRequest) -> None:
    if name == "postgres":
        request.getfixturevalue("database")
    outcome = feed(name, COUNT, seed=20261121, seconds=SECONDS)
    assert outcome.tries >= 1
    assert outcome.faults == 0, outcome.found
    assert outcome.grown < 600 << 20


def test_commands_end_with_one_line_a_fault_whatever_numbers_stand_in_the_files(tmp_path: Path) -> None:
    for number in (1, 2, 3):
        assert feed_one("commands", 20261121, number, tmp_path)[0] in ("accepted", "refused")


@pytest.mark.parametrize(("name", "count"), [("stores", 20), ("plugins", 12)])
def test_a_strangers_store_or_code_is_refused_or_used_inside_its_fence(name: str, count: int, tmp_path: Path) -> None:
    for number in range(count):
        assert feed_one(name, 20261122, number, tmp_path)[0] in ("accepted", "refused"), number


def test_inputs_go_on_where_another_call_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    from tests.fuzz import feeding

    monkeypatch.setattr(feeding, "targets", lambda: {"one": lambda *_: None})
    assert feeding.feed("one", 5, 1, first=3).counts == {"accepted": 2}


def test_what_leaves_the_folder_is_found(tmp_path: Path) -> None:
    """The fence itself: a secret that is opened, a file that is written elsewhere, a link, a connection."""
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    for folder in (inside, outside):
        folder.mkdir()
        (folder / "file").write_text("x")
    (inside / "link").symlink_to(outside / "file")
    deeds = (
        lambda: (inside / "link").read_text(),
        lambda: (tmp_path / "elsewhere").write_text("x"),
        lambda: (inside / "hard").hardlink_to(outside / "file"),
        lambda: (inside / "file").rename(tmp_path / "elsewhere"),
        lambda: socket.create_connection(("127.0.0.1", 9)),
        lambda: subprocess.run(["true"]),
    )
    for deed in deeds:
        with pytest.raises(BrokenFenceError), FENCE.around((inside,), outside):
            deed()
    with FENCE.around((inside,), outside):
        (inside / "file").write_text("y")


def test_a_fault_of_the_program_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bench itself: a traceback, a hang, a crash, an unclear line and a flood of memory are each seen."""
    import itertools
    import os
    import time

    from stiffcal.errors import InputError
    from tests.fuzz import feeding

    def refuse(*_: object) -> None:
        raise InputError.at(FaultCode.VALUE_INVALID, "a", "", "", "")

    tries = itertools.count(1)
    deeds = {
        "traceback": lambda *_: 1 / 0,
        "hang": lambda *_: time.sleep(60) if next(tries) % 2 else sum(1 for _ in itertools.count()),
        "crash": lambda *_: os._exit(7),
        "unclear": refuse,
        "memory": lambda *_: b"x" * (256 << 20 if next(tries) % 2 else 512 << 20) and None,
    }
    monkeypatch.setattr(feeding, "targets", lambda: deeds)
    monkeypatch.setattr(feeding, "MOST_GROWN", 128 << 20)
    for name in deeds:
        monkeypatch.setattr(feeding, "MOST_SECONDS", 0.2 if name == "hang" else 30.0)
        assert feeding.feed(name, 2, 1).counts == {name: 2}


@pytest.mark.parametrize(
    ("file", "text", "words"),
    [
        ("campaign.toml", "x = " + "[" * 5000 + "]" * 5000, "too deeply"),
        ("campaign.toml", "x = " + "[" * 100 + "]" * 100, "too deeply"),
        ("campaign.toml", "[" + ".".join(["a"] * 20_000) + "]\nb = 1", "too deeply"),
        ("campaign.toml", "x = " + "9" * 5000, "thousands of digits"),
        ("campaign.toml", "[frames.tool]\nparent = 'flange'\nxyz_m = [" + "9" * 400 + ", 0, 0]", "400 digits"),
        ("campaign.toml", "x = 0x" + "f" * 5000, "6021 digits"),
        ("model.toml", "effects = [{ effect = 'backlash', joints = [0b" + "1" * 20_000 + "] }]", "6021 digits"),
        ("campaign.toml", '"a\\nb" = 1', "a\\nb"),
        ("campaign.toml", "[sources.s]\njoints = { position = 'A1..A999999999' }", "more than 1000 columns"),
        ("campaign.toml", "\n".join(f"k{n} = 1" for n in range(900)), "more faults"),
        ("robot.toml", "gravity_mps2 = [0.0, 0.0, 1e300]", "1e+300 is larger"),
        ("robot.toml", "joints = " + "[" * 30 + "]" * 30, "too deeply"),
        ("model.toml", "effects = [{ type = 'x', pairs = ['" + "y" * 900 + "'] }]", "is not a pair"),
        ("model.toml", "effects = [{ type = 'x', pairs = ['" + "y" * 50_000 + "'] }]", "50000 characters"),
    ],
)
def test_what_was_found_is_one_clear_line(
    file: str, text: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_campaign(tmp_path / "c")
    schema = file.removesuffix(".toml")
    (folder / file).write_text(f'schema = "stiffcal/{schema}/1"\n{text}\n', encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main(["check", str(folder)])
    reported = capsys.readouterr().err
    assert end.value.code == 2
    assert words in reported
    assert all(line.startswith(file) and len(line) < 2500 for line in reported.splitlines())
