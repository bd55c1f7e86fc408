"""A campaign folder that brings a store with it: a stranger's results are computed again, one's own are not."""

from __future__ import annotations

import hashlib
import json
import mmap
import os
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest

from stiffcal.batch import task as batch_task
from stiffcal.batch.task import run_task
from stiffcal.cli.app import main
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.results.batch_results import BatchTask
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.store.file_systems import shows_mapped_writes
from stiffcal.trust.record import open_record
from tests.laboratory.delivered_store import NOT_YOURS, batch, forge, hold, without_logs
from tests.laboratory.small_campaign import write_small_campaign


def test_forged_results_do_not_make_batch_say_held(delivered: Path) -> None:
    forge(delivered, "validate", hold)
    forge(delivered, "identify", lambda document: document.update(rms={"translation": 1e-12, "rotation": 1e-12}))
    outcome = batch(delivered)
    assert outcome.state == "not held"
    assert outcome.origin == "own"
    assert outcome.steps["ingest"].why == "the store was not written by you: recomputed"
    assert outcome.rms is not None
    assert (outcome.rms.translation or 0.0) > 1e-6


def test_results_of_one_own_are_not_computed_again(delivered: Path) -> None:
    said: list[str] = []
    first = validate_campaign(delivered, RunContext(notify=said.append))
    assert said == [NOT_YOURS, "running identify: nothing is fitted yet"]
    said.clear()
    assert validate_campaign(delivered, RunContext(notify=said.append)) == first
    assert identify_campaign(delivered).origin == first.origin == "own"
    assert said == []


@pytest.mark.parametrize("how", ["copied", "moved", "links followed"])
def test_an_own_store_stays_own_wherever_it_lies(delivered: Path, tmp_path: Path, how: str) -> None:
    validate_campaign(delivered)
    goal = tmp_path / "elsewhere"
    if how == "moved":
        delivered.rename(goal)
    else:
        shutil.copytree(delivered, goal, symlinks=how == "copied")
    said: list[str] = []
    assert validate_campaign(goal, RunContext(notify=said.append)).origin == "own"
    assert said == []


def test_a_document_changed_in_an_own_store_is_computed_again(delivered: Path) -> None:
    true = validate_campaign(delivered)
    forge(delivered, "validate", hold)  # with its index: the generation is nobody's now
    assert batch(delivered).state == "not held"
    current = delivered / "store" / "current"
    document = json.loads((current / "validate.json").read_text("utf-8"))
    hold(document)
    (current / "validate.json").write_text(json.dumps(document), "utf-8")  # without it
    said: list[str] = []
    again = validate_campaign(delivered, RunContext(notify=said.append))
    assert document_of(again.rms) == pytest.approx(document_of(true.rms))
    assert again.passed is False
    assert any("validate: damaged" in line and "computed again" in line for line in said)


@pytest.mark.skipif(os.name == "nt", reason="Windows keeps no time of change of an inode: there all is hashed")
def test_a_log_rewritten_with_its_size_and_time_kept_is_noticed(tmp_path: Path, state: Path) -> None:
    folder = write_small_campaign(tmp_path / "mine", poses=2)
    log = folder / "raw" / "states.csv"
    os.utime(log, ns=(log.stat().st_atime_ns, log.stat().st_mtime_ns - 10**12))
    before = identify_campaign(folder)
    found, text = log.stat(), log.read_text()
    last = text.rstrip()[-1]
    log.write_text(text.rstrip()[:-1] + ("1" if last != "1" else "2") + "\n")
    os.utime(log, ns=(found.st_atime_ns, found.st_mtime_ns))
    assert (log.stat().st_size, log.stat().st_mtime_ns) == (found.st_size, found.st_mtime_ns)
    said: list[str] = []
    after = identify_campaign(folder, RunContext(notify=said.append))
    assert said[0] == "running ingest: changed: raw/states.csv"
    assert after.key != before.key


@pytest.mark.skipif(sys.platform == "win32", reason="a mapped file cannot be replaced there")
@pytest.mark.parametrize("large", [False, True])
def test_what_is_written_through_a_mapping_is_seen(
    large: bool, delivered: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file's times stand still while a page that was written to waits for the disk."""
    from stiffcal.store import source_files

    monkeypatch.setattr(source_files, "RACY_NS", -(10**18))  # as if the first write had been long ago
    monkeypatch.setattr(source_files, "ALWAYS_HASHED", 0 if large else 1 << 20)
    log = delivered / "raw" / "states.csv"
    with log.open("r+b") as file, mmap.mmap(file.fileno(), 0) as mapped:
        last = len(mapped) - 2
        mapped[last] = mapped[last]  # from now on the page waits
        os.utime(log, ns=(log.stat().st_atime_ns, log.stat().st_mtime_ns - 10**12))
        identify_campaign(delivered)
        validate_campaign(delivered)  # finds nothing changed, and remembers it
        mapped[last] = ord("1") if mapped[last] != ord("1") else ord("2")
        said: list[str] = []
        identify_campaign(delivered, RunContext(notify=said.append))
    assert said[0] == "running ingest: changed: raw/states.csv"


def test_logs_are_not_hashed_again_where_the_file_system_says_they_are_unchanged(
    delivered: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from stiffcal.store import source_files

    if not shows_mapped_writes(delivered):
        pytest.skip("this file system does not show every change in the files' times")
    monkeypatch.setattr(source_files, "RACY_NS", -(10**18))  # as if the logs had been written long ago
    monkeypatch.setattr(source_files, "ALWAYS_HASHED", 0)  # as if they were large
    identify_campaign(delivered)
    hashed: list[str] = []
    true_hash = source_files.hash_file

    def hash_file(folder: Path, file: str, *rest: Any) -> Any:
        hashed.append(file)
        return true_hash(folder, file, *rest)

    monkeypatch.setattr(source_files, "hash_file", hash_file)
    identify_campaign(delivered)
    validate_campaign(delivered)
    assert hashed == []
    batch(delivered)
    assert hashed == ["raw/states.csv"]  # a batch looks at all that counts


def test_in_a_trusted_place_what_others_wrote_counts(delivered: Path, state: Path) -> None:
    open_record().allow_place(str(delivered.parent))
    said: list[str] = []
    document = validate_campaign(delivered, RunContext(notify=said.append))
    assert said == []
    assert document.origin == "trusted place"
    assert document.passed is False
    assert "not computed by you" not in document.failed[0]
    open_record().revoke(str(delivered.parent))
    assert validate_campaign(delivered, RunContext(notify=said.append)).origin == "own"
    assert said[0] == NOT_YOURS


def test_store_option_is_no_proof_of_origin(delivered: Path) -> None:
    said: list[str] = []
    means = RunContext(store=str(delivered / "store"), notify=said.append)
    assert identify_campaign(delivered, means).origin == "own"
    assert said[0] == NOT_YOURS


def test_where_nothing_can_be_remembered_each_step_is_computed_once(
    delivered: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    inside = delivered / "state"  # a record in the campaign folder is not believed
    monkeypatch.setenv("STIFFCAL_STATE", str(inside))
    said: list[str] = []
    document = validate_campaign(delivered, RunContext(notify=said.append))
    assert document.origin == "own"
    assert len(said) == 2
    assert not inside.exists()
    lines = [line for line in capsys.readouterr().err.splitlines() if "nothing is remembered" in line]
    assert len(lines) == 1


def test_no_update_refuses_a_strangers_store(delivered: Path) -> None:
    with pytest.raises(InputError, match="the store was not written by you"):
        identify_campaign(delivered, RunContext(update=False))


def test_a_delivered_report_does_not_pass_for_the_one_of_this_batch(
    delivered: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(folder: Path, means: RunContext, output: Path) -> None:
        output.write_bytes(b"by the user")

    monkeypatch.setattr(batch_task, "report_campaign", write)
    forged = b"all thresholds hold"
    (without_logs(delivered) / "report.pdf").write_bytes(forged)
    key = batch_task._report_key(up_to_date_states(delivered, RunContext()))
    made = {"schema": "stiffcal/report-made/1", "key": key, "sha256": hashlib.sha256(forged).hexdigest()}
    current = (delivered / "store" / "current").resolve()
    index = json.loads((current / "generation.json").read_text("utf-8"))
    index["documents"]["report"] = {"bytes": 0, "sha256": ""}
    (current / "generation.json").write_text(json.dumps(index), "utf-8")
    (current / "report.json").write_text("{}", "utf-8")
    forge(delivered, "report", lambda document: document.update(made))
    assert run_task(BatchTask(folder=str(delivered), campaign="small")).error is None
    assert (delivered / "report.pdf").read_bytes() == b"by the user"


@pytest.mark.parametrize("option", ["--store", "--revoke"])
@pytest.mark.parametrize("name", ["", " "])
def test_an_empty_name_is_not_the_current_folder(
    option: str, name: str, state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`trust --store "$CACHE"` where CACHE is not set trusted whatever lies in the current folder."""
    with pytest.raises(SystemExit) as end:
        main(["trust", option, name, "--yes"])
    assert end.value.code == 2
    words = f'command line: {option}: is empty; name it in full, the current folder as "."'
    assert capsys.readouterr().err == f"{words} [option-invalid]\n"
    assert not open_record().entries()
