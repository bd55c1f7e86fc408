"""The record of trust: the user's alone, whole at any instant, and never brought along by a campaign folder."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from stiffcal.errors import InputError
from stiffcal.trust import record
from stiffcal.trust.content import MOST_GENERATIONS, RecordContent, to_json
from stiffcal.trust.record import CommittedGeneration, TrustRecord, open_record

EMPTY = to_json(RecordContent())
posix = pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")


def digest(number: int) -> str:
    return f"{number:064x}"


def generation(number: int) -> CommittedGeneration:
    return CommittedGeneration(digest(number), digest(number + 1), "2026-11-22T12:00:00Z")


@pytest.fixture(autouse=True)
def _other_process(state: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a test reads comes from the file, as in another process."""
    monkeypatch.setattr(record, "_of_this_process", {})


def as_another_process() -> TrustRecord:
    record._of_this_process.clear()
    record._cached.clear()
    return open_record()


def test_an_empty_record_trusts_nothing(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    trust = open_record()
    assert not trust.plugin_allowed(digest(1))
    assert not trust.text_allowed(digest(1))
    assert not trust.folder_allowed(state)
    assert not trust.place_allowed("s3://lab/cells")
    assert trust.generation(digest(1)) is None
    assert trust.entries() == []
    assert capsys.readouterr() == ("", "")
    assert not state.exists()  # asking writes nothing


def test_what_was_allowed_is_known_to_the_next_process_and_revoked_again(state: Path, tmp_path: Path) -> None:
    trust = open_record()
    trust.allow_plugin(digest(1), str(tmp_path))
    trust.allow_text(digest(2), "campaign.toml")
    trust.allow_folder(tmp_path)
    trust.allow_place("s3://lab/cells/")
    trust.remember_generation(generation(3))
    later = as_another_process()
    assert later.plugin_allowed(digest(1))
    assert not later.text_allowed(digest(1))
    assert later.text_allowed(digest(2))
    assert not later.plugin_allowed(digest(2))
    assert later.folder_allowed(tmp_path)
    assert not later.folder_allowed(tmp_path / "below")
    assert later.place_allowed("s3://lab/cells/a")
    assert later.generation(digest(3)) == generation(3)
    assert [entry.kind for entry in later.entries()] == ["folder", "place", "plugin", "text", "generation"]
    # the folder's name takes away what was allowed there too
    assert {entry.key for entry in later.revoke(str(tmp_path))} == {digest(1), str(tmp_path)}
    later.revoke(digest(3))
    last = as_another_process()
    assert {entry.kind for entry in last.entries()} == {"place", "text"}


@pytest.mark.parametrize(
    ("allowed", "asked", "held"),
    [
        ("s3://lab/cells", "s3://lab/cells", True),
        ("s3://lab/cells", "s3://lab/cells/a/b", True),
        ("s3://lab/cells/", "S3://lab/cells/", True),
        ("s3://lab/cells", "s3://lab/cells-of-others", False),
        ("s3://lab/cells", "s3://lab", False),
        ("s3://lab/cells", "s3://lab/cells/../others", False),
        ("s3://lab/cells", "s3://lab/cells//a", False),
        ("s3://lab/cells", "gs://lab/cells/a", False),
        ("s3://lab/cells", "s3://lab/cells/a?endpoint_override=elsewhere", False),
        ("s3://lab/cells?region=a", "s3://lab/cells?region=a", True),
    ],
)
def test_a_trusted_place_holds_what_lies_below_it_alone(state: Path, allowed: str, asked: str, held: bool) -> None:
    open_record().allow_place(allowed)
    assert open_record().place_allowed(asked) is held


def test_a_trusted_folder_of_stores_goes_by_where_links_lead(state: Path, tmp_path: Path) -> None:
    for name in ("drive/cells", "drive-of-others"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "drive" / "link").symlink_to(tmp_path / "drive-of-others")
    open_record().allow_place(str(tmp_path / "drive"))
    trust = open_record()
    assert trust.place_allowed(str(tmp_path / "drive" / "cells"))
    assert not trust.place_allowed(str(tmp_path / "drive" / "link"))
    assert not trust.place_allowed(str(tmp_path / "drive-of-others"))
    assert not trust.place_allowed(str(tmp_path / "drive" / ".." / "drive-of-others"))


def test_hashes_in_the_environment_count_like_those_in_the_record(state: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFCAL_TRUST", f"{digest(1)}, {digest(2)}{os.pathsep}{digest(10).upper()}\n")
    trust = open_record()
    assert [trust.plugin_allowed(digest(number)) for number in (1, 2, 3, 10)] == [True, True, False, True]
    assert trust.text_allowed(digest(2))
    monkeypatch.setenv("STIFFCAL_TRUST", "all")
    with pytest.raises(
        InputError, match=r"STIFFCAL_TRUST: 'all' is not a SHA-256; give the hash that stiffcal trust --hash DIR"
    ):
        trust.plugin_allowed(digest(1))


@posix
def test_folder_and_file_are_the_users_alone_whatever_the_umask(state: Path) -> None:
    before = os.umask(0o002)
    try:
        open_record().allow_plugin(digest(1), "")
    finally:
        os.umask(before)
    assert stat.S_IMODE(state.stat().st_mode) == 0o700
    assert stat.S_IMODE((state / "trust.json").stat().st_mode) == 0o600
    assert [file.name for file in sorted(state.iterdir())] == ["trust.json", "trust.lock"]


@posix
@pytest.mark.parametrize(("name", "mode"), [("", 0o770), ("", 0o707), ("trust.json", 0o660), ("trust.json", 0o602)])
def test_a_record_that_others_can_write_is_not_believed(
    state: Path, name: str, mode: int, capsys: pytest.CaptureFixture[str]
) -> None:
    open_record().allow_plugin(digest(1), "")
    (state / name).chmod(mode)
    trust = as_another_process()
    assert not trust.plugin_allowed(digest(1))
    trust.remember_generation(generation(2))
    said = capsys.readouterr().err
    assert "others can write to it" in said
    assert "chmod" in said
    with pytest.raises(InputError, match="cannot remember this"):
        trust.allow_plugin(digest(3), "")
    (state / name).chmod(0o700)
    assert as_another_process().generation(digest(2)) is None


@posix
def test_an_empty_state_folder_of_an_earlier_version_is_closed_to_others(state: Path) -> None:
    state.mkdir(mode=0o755)
    (state / "plugins.json").write_text("{}", encoding="ascii")
    open_record().allow_plugin(digest(1), "")
    assert stat.S_IMODE(state.stat().st_mode) == 0o700


@pytest.mark.parametrize("place", ["state", "store/deep/state", "."])
def test_a_record_inside_a_campaign_folder_is_not_believed(
    state: Path, tmp_path: Path, place: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    inside = tmp_path / "stranger" / place
    inside.mkdir(parents=True, mode=0o700)
    content = RecordContent()
    content.add([generation(1)])
    (inside / "trust.json").write_text(to_json(content), encoding="ascii")
    (inside / "trust.json").chmod(0o600)
    monkeypatch.setenv("STIFFCAL_STATE", str(inside))
    assert open_record().generation(digest(1)) is not None
    (tmp_path / "stranger" / "campaign.toml").write_text("", encoding="ascii")
    trust = as_another_process()
    assert trust.generation(digest(1)) is None
    assert "inside the campaign folder" in capsys.readouterr().err
    with pytest.raises(InputError, match="inside the campaign folder"):
        trust.allow_plugin(digest(2), "")


def test_a_link_into_a_campaign_folder_is_the_campaigns_record(
    state: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "stranger" / "state").mkdir(parents=True)
    (tmp_path / "stranger" / "campaign.toml").write_text("", encoding="ascii")
    (tmp_path / "link").symlink_to(tmp_path / "stranger" / "state")
    monkeypatch.setenv("STIFFCAL_STATE", str(tmp_path / "link"))
    with pytest.raises(InputError, match="inside the campaign folder"):
        open_record().allow_plugin(digest(1), "")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "null",
        '{"schema": 1}',
        '{"schema": "stiffcal/trust-record/1"}',
        '{"schema": "something/else"}',
        EMPTY.replace('"plugin":[]', '"plugin":[["no hash","",""]]'),
        EMPTY.replace('"plugin":[]', '"plugin":[[1]]'),
        EMPTY.replace('"generation":[]', '"generation":[["x","",""]]'),
        "[" * 100_000,
        "é",
    ],
)
def test_a_damaged_record_is_set_aside_and_trusts_nothing(
    state: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    open_record().allow_plugin(digest(1), "")
    (state / "trust.json").write_text(text, encoding="utf-8")
    trust = as_another_process()
    assert not trust.plugin_allowed(digest(1))
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "is damaged" in said
    (aside,) = state.glob("trust.json.damaged-*")
    assert aside.read_text(encoding="utf-8") == text
    trust.allow_plugin(digest(2), "")
    assert as_another_process().plugin_allowed(digest(2))


def test_a_record_of_a_newer_version_stays_as_it_is(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    state.mkdir(mode=0o700)
    newer = json.dumps({"schema": "stiffcal/trust-record/2", "something": "else"})
    (state / "trust.json").write_text(newer, encoding="ascii")
    trust = open_record()
    trust.remember_generation(generation(1))
    assert "update stiffcal" in capsys.readouterr().err
    assert (state / "trust.json").read_text(encoding="ascii") == newer


def test_where_nothing_can_be_remembered_a_process_knows_what_it_wrote_itself_and_says_so_once(
    state: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("", encoding="ascii")
    monkeypatch.setenv("STIFFCAL_STATE", str(tmp_path / "file" / "state"))
    open_record().remember_generation(generation(1))
    open_record().remember_generation(generation(2))
    assert open_record().generation(digest(1)) == generation(1)
    assert open_record().generation(digest(2)) == generation(2)
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "nothing is remembered from one command to the next" in said
    assert as_another_process().generation(digest(1)) is None


def test_without_a_home_commands_go_on(
    state: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    for name in ("STIFFCAL_STATE", "XDG_STATE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", staticmethod(no_home))
    open_record().remember_generation(generation(1))
    assert open_record().generation(digest(1)) == generation(1)
    assert "no home folder" in capsys.readouterr().err
    with pytest.raises(InputError, match="no home folder"):
        open_record().allow_plugin(digest(1), "")


def test_the_newest_generations_are_kept(state: Path) -> None:
    trust = open_record()
    trust.remember_generation(*(generation(number) for number in range(MOST_GENERATIONS)))
    trust.remember_generation(generation(0), generation(MOST_GENERATIONS))
    later = as_another_process()
    assert later.generation(digest(0)) is not None  # written again: the newest but one
    assert later.generation(digest(1)) is None
    assert later.generation(digest(2)) is not None
    assert len(later.entries()) == MOST_GENERATIONS


WRITER = """
import sys
from stiffcal.trust.record import CommittedGeneration, open_record
for number in range(20):
    digest = f"{1000 * int(sys.argv[1]) + number:064x}"
    open_record().remember_generation(CommittedGeneration(digest, "", "2026-11-22T12:00:00Z"))
    open_record().allow_plugin(digest, "")
"""


def test_of_processes_that_write_at_once_none_loses_anything(state: Path) -> None:
    writers = [subprocess.Popen([sys.executable, "-P", "-c", WRITER, str(number)]) for number in range(4)]
    assert [writer.wait(timeout=60) for writer in writers] == [0] * 4
    trust = as_another_process()
    for number in (1000 * writer + row for writer in range(4) for row in range(20)):
        assert trust.generation(digest(number)) is not None
        assert trust.plugin_allowed(digest(number))
    assert sorted(file.name for file in state.iterdir()) == ["trust.json", "trust.lock"]


def test_the_record_is_light_to_import() -> None:
    code = "import sys, stiffcal.trust.record; print(' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "pyarrow", "pydantic", "typer"} & set(done.stdout.split())
