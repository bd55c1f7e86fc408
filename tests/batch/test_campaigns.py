"""Many campaigns in one go: each its own verdict, what has not changed is left alone, nobody stops the others."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import pytest

from stiffcal.batch import processes as batch_processes
from stiffcal.batch.campaigns import BatchOptions, batch_campaigns, cores, find_campaigns
from stiffcal.batch.processes import WorkerLostError, WorkerProcess
from stiffcal.batch.summary import junit_text, markdown_text
from stiffcal.batch.task import run_task
from stiffcal.cli.app import main
from stiffcal.cli.ended_in_order import ended_in_order
from stiffcal.documents import document_of, result_from_values
from stiffcal.errors import InputError, Progress
from stiffcal.fault_codes import FaultCode
from stiffcal.report.content import ReportContent
from stiffcal.results.batch_results import BatchCounts, BatchResult, BatchTask, BatchWorkers, CampaignOutcome
from stiffcal.store import Store
from stiffcal.validation.results import ThresholdCheck
from tests.laboratory import children
from tests.laboratory.batch_plugins import COMPUTES, KILLED, STANDS, WAITS, with_plugin
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.long

Document = dict[str, Any]
LONGEST_S = 240.0  # on a machine with ten times as much to do as it can


@pytest.fixture(scope="module")
def cells(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three campaigns, of which one is wrong, and a folder that is none; all computed once."""
    cells = tmp_path_factory.mktemp("cells") / "cells"
    for seed, name in enumerate(("a", "b")):
        folder = write_small_campaign(cells / name, seed=seed, poses=2)
        run_task(BatchTask(folder=str(folder), campaign=name, report=False))
    shutil.copytree(cells / "a", cells / "broken")
    (cells / "broken" / "robot.toml").write_text("name =", encoding="utf-8")
    (cells / "notes").mkdir()
    return cells


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run tasks here, where they need not be started for a second each; most is not about processes."""

    def run(tasks: Sequence[BatchTask], jobs: int, finished: Callable[[CampaignOutcome], None]) -> None:
        for task in tasks:
            document = json.loads(json.dumps(document_of(run_task(task))))
            finished(result_from_values(CampaignOutcome, document))

    monkeypatch.setattr(batch_processes, "run_on_this_machine", run)


@pytest.fixture
def unprinted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pages away: ten seconds each time, and `tests/report` reads them."""

    def touch(content: ReportContent, output: Path, progress: Progress, is_short: bool) -> None:
        output.write_bytes(b"%PDF")

    monkeypatch.setattr("stiffcal.report.building.build_report", touch)


@pytest.fixture
def copied(cells: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(cells, tmp_path / "cells", symlinks=True))


def by_name(result: BatchResult) -> dict[str, CampaignOutcome]:
    return {outcome.campaign.split("/")[-1]: outcome for outcome in result.campaigns}


def done(outcome: CampaignOutcome) -> list[str]:
    return [name for name, step in outcome.steps.items() if step.done]


def test_campaigns_are_found_once_and_in_order(cells: Path, tmp_path: Path) -> None:
    shutil.copytree(cells / "a", tmp_path / "x" / "deep" / "a" / "inside")
    shutil.copytree(cells / "a", tmp_path / "y" / "a")
    shutil.copytree(cells / "a", tmp_path / "y" / "a" / "store" / "not-looked-at")
    found, absent = find_campaigns([tmp_path / "y", cells / "b", tmp_path, cells / ".." / "cells" / "b"])
    assert [label for _, label in found] == ["y/a", "b", f"{tmp_path.name}/x/deep/a/inside"]
    assert not absent
    found, absent = find_campaigns([cells / "notes", cells / "b"])
    assert [outcome.error and outcome.error.reason for outcome in absent] == ["there is no campaign.toml in it"]
    with pytest.raises(InputError, match="no such folder; give a campaign folder"):
        find_campaigns([tmp_path / "nowhere"])


def test_campaigns_of_one_label_are_distinguished(cells: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        shutil.copytree(cells / "a", tmp_path / name / "a")
    found, _ = find_campaigns([tmp_path / "one" / "a", tmp_path / "two" / "a"])
    labels = [label for _, label in found]
    assert len(set(labels)) == 2
    assert labels[0].endswith("one/a")


def test_one_broken_campaign_does_not_stop_the_others(copied: Path) -> None:
    for name in ("a", "b"):
        shutil.rmtree(copied / name / "store")
    heard: list[tuple[int, int]] = []
    wishes = BatchOptions(jobs=2, report=False, finished=lambda _, done, of: heard.append((done, of)))
    result = batch_campaigns([copied], wishes)
    states = {name: outcome.state for name, outcome in by_name(result).items()}
    assert states == {"a": "held", "b": "held", "broken": "broken"}
    assert result.passed is False
    assert result.counts == BatchCounts(campaigns=3, held=2, not_held=0, broken=1, unchanged=0)
    assert heard == [(1, 3), (2, 3), (3, 3)]
    outcome = by_name(result)["broken"]
    assert outcome.error is not None
    assert (outcome.failed_at, outcome.error.file) == ("ingest", "robot.toml")
    assert done(by_name(result)["a"]) == ["ingest", "identify", "validate"]
    memory = result.peak_memory_bytes
    assert memory is None or 50e6 < memory < 400e6


@pytest.mark.usefixtures("in_this_process")
def test_unchanged_campaigns_are_not_computed_again(copied: Path) -> None:
    generation = Store(copied / "a" / "store").generation
    model = copied / "b" / "model.toml"
    model.write_text(model.read_text(encoding="utf-8").replace("[1, 2, 3, 4, 5, 6]", "[1, 2, 3, 4, 5]"), "utf-8")
    found = by_name(batch_campaigns([copied], BatchOptions(jobs=1, report=False)))
    assert done(found["a"]) == []
    assert Store(copied / "a" / "store").generation == generation
    assert done(found["b"]) == ["identify", "validate"]
    assert found["b"].steps["identify"].why == "the model or the load states have changed"


@pytest.mark.usefixtures("in_this_process")
def test_a_note_about_missing_logs_is_no_step(copied: Path) -> None:
    """What is stored is used; nothing was computed, and the campaign counts as unchanged."""
    shutil.rmtree(copied / "a" / "raw")
    result = batch_campaigns([copied / "a"], BatchOptions(jobs=1, report=False))
    outcome = by_name(result)["a"]
    assert done(outcome) == []
    assert outcome.steps["ingest"].why.startswith("the logs are missing (raw/")
    assert result.counts.unchanged == 1


@pytest.mark.usefixtures("in_this_process")
def test_thresholds_of_a_file(copied: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "thresholds.toml"
    shutil.rmtree(copied / "broken")
    text = 'schema = "stiffcal/thresholds/1"\n[validate]\nmax_rms_m = 1e-4\n'
    file.write_text(text, "utf-8")
    words = ["batch", str(copied), "--thresholds", str(file), "--no-report", "--json"]
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 0
    file.write_text(text + "[campaigns.b.validate]\nmin_stiffness = { A6 = 1e6 }\n[campaigns.c.validate]\n", "utf-8")
    capsys.readouterr()
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 1
    document = json.loads(capsys.readouterr().out)
    assert [one["state"] for one in document["campaigns"]] == ["held", "not held"]
    assert document["warnings"] == ["the thresholds of c belong to no campaign in this batch"]


@pytest.mark.usefixtures("in_this_process")
def test_the_summary_names_what_does_not_hold(copied: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = copied / "b" / "campaign.toml"
    limits = "\n[thresholds]\nmax_rms_m = 1e-6\nmax_relative = 0.9\n"
    manifest.write_text(manifest.read_text(encoding="utf-8") + limits, encoding="utf-8")
    junit, markdown = tmp_path / "junit.xml", tmp_path / "summary.md"
    with pytest.raises(SystemExit) as end:
        main(["batch", str(copied), "--no-report", "--junit", str(junit), "--markdown", str(markdown)])
    assert end.value.code == 1
    reported = capsys.readouterr()
    assert "cells/b: NOT held: rms in held-out poses" in reported.out
    assert "cells/broken: broken: " in reported.out
    assert reported.out.rstrip().splitlines()[-1].endswith(f": stiffcal check {copied / 'broken'}")
    assert reported.out.startswith("FAIL  3 campaigns: 1 held, 1 not held, 1 broken")
    root = ElementTree.parse(junit).getroot()
    assert (root.get("tests"), root.get("failures"), root.get("errors"), root.get("skipped")) == ("13", "1", "1", "3")
    (failed,) = root.iter("failure")
    assert failed.get("message", "no message") in reported.out
    text = markdown.read_text(encoding="utf-8")
    assert text.startswith("## stiffcal: campaigns fail\n")
    rows = [line.split(" | ")[1] for line in text.splitlines() if line.startswith("| cells/")]
    assert rows == ["done", "**NOT held**", "**broken**"]


@pytest.mark.usefixtures("in_this_process")
def test_summaries_bear_any_text(cells: Path) -> None:
    result = batch_campaigns([cells / "a"], BatchOptions(jobs=1, report=False))
    outcome = replace(
        result.campaigns[0],
        campaign="a\x00|b <script> & `c`\n_d_",
        checks=[ThresholdCheck("max_rms_m", "", 1e-4, 2e-4, "m", False, "\x1b[1m]]> \ud800")],
        failed=["\x1b[1m]]> \ud800"],
    )
    result = replace(result, campaigns=[outcome])
    suite = ElementTree.fromstring(junit_text(result))[0]
    assert suite.get("name") == "a\\x00|b <script> & `c`\\n_d_"
    row = markdown_text(result).splitlines()[-1]
    assert row.startswith("| a&#92;x00&#124;b &lt;script&gt; &amp; \\`c\\`&#92;n\\_d\\_ | ")
    assert "- **" in markdown_text(result)


@pytest.mark.usefixtures("in_this_process", "unprinted")
def test_stores_and_reports_elsewhere(tmp_path: Path) -> None:
    write_small_campaign(tmp_path / "fresh", poses=2)
    wishes = BatchOptions(jobs=1, store=str(tmp_path / "stores"), reports=tmp_path / "pdf")
    (outcome,) = batch_campaigns([tmp_path / "fresh"], wishes).campaigns
    pdf = tmp_path / "pdf" / "fresh.pdf"
    assert outcome.report == str(pdf)
    assert pdf.read_bytes().startswith(b"%PDF")
    assert not (tmp_path / "fresh" / "store").exists()
    assert "fit" in Store(tmp_path / "stores" / "fresh").tables
    (outcome,) = batch_campaigns([tmp_path / "fresh"], wishes).campaigns
    assert done(outcome) == []
    with pdf.open("ab") as file:
        file.write(b"scribbled on")
    # what somebody has changed is not written over
    (outcome,) = batch_campaigns([tmp_path / "fresh"], wishes).campaigns
    assert done(outcome) == []
    assert outcome.failed_at == "report"
    assert pdf.read_bytes().endswith(b"scribbled on")
    pdf.unlink()
    (outcome,) = batch_campaigns([tmp_path / "fresh"], wishes).campaigns
    assert done(outcome) == ["report"]


def test_with_default_options_a_batch_ends(tmp_path: Path) -> None:
    """Everything in processes of its own, with the pages; where one of them waits for ever, the time limit ends it."""
    folder = write_small_campaign(tmp_path / "cell", poses=2)
    command = [sys.executable, "-P", "-m", "stiffcal", "batch", str(folder), "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, timeout=LONGEST_S, check=True)
    (outcome,) = json.loads(done.stdout)["campaigns"]
    assert outcome["report"] == str(folder / "report.pdf")
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")


def test_a_killed_process_costs_a_retry(copied: Path) -> None:
    once = f"if not (HERE / 'killed').exists():\n    (HERE / 'killed').touch()\n    {KILLED}"
    with_plugin(copied / "a", once)
    with_plugin(copied / "broken", KILLED)
    shutil.copy(copied / "a" / "robot.toml", copied / "broken" / "robot.toml")
    found = by_name(batch_campaigns([copied], BatchOptions(jobs=2, report=False)))
    assert {name: outcome.state for name, outcome in found.items()} == {"a": "held", "b": "held", "broken": "broken"}
    error = found["broken"].error
    assert error is not None
    assert (error.file, error.place) == ("own.py", "plugins")
    assert error.reason.startswith("its process was ended by signal 9: ")
    assert error.reason.endswith(", 2 times, after code of this campaign began to run")
    assert (copied / "a" / "killed").exists()
    assert (copied / "a" / "threads").read_text() == "1"
    assert len(found["a"].warnings) == 1 + len(found["b"].warnings)  # of the process that was lost


@pytest.mark.parametrize(("large", "processes"), [(1 << 30, 1), (1, 3)])
def test_a_process_that_has_grown_is_replaced(
    cells: Path, monkeypatch: pytest.MonkeyPatch, large: int, processes: int
) -> None:
    started: list[WorkerProcess] = []

    def start() -> WorkerProcess:
        started.append(WorkerProcess())
        return started[-1]

    monkeypatch.setattr(batch_processes, "LARGE_BYTES", large)
    monkeypatch.setattr(batch_processes, "WorkerProcess", start)
    batch_campaigns([cells], BatchOptions(jobs=1, report=False))
    assert len(started) == processes
    assert not any(alive(worker.pid) for worker in started)


@pytest.mark.parametrize("answer", ['{"campaign": 1}', "[1]", "{", '{"step": "report", "steps": 3}', "1"])
def test_what_is_no_outcome_counts_as_a_lost_process(answer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_processes, "work", children.answer_with_the_campaigns_name)
    worker = WorkerProcess()
    try:
        with pytest.raises(WorkerLostError, match="something other than a result"):
            worker.do(BatchTask(folder="a", campaign=answer))
    finally:
        worker.stop()


def test_a_process_without_progress_is_lost_and_the_others_go_on(copied: Path) -> None:
    """One waits for what does not come, one computes in its plugin without end, one is stopped by the system."""
    shutil.rmtree(copied / "broken")
    for name, hang in (("waits", WAITS), ("computes", COMPUTES), ("stands", STANDS)):
        with_plugin(Path(shutil.copytree(copied / "a", copied / name)), hang)
    shutil.rmtree(copied / "b" / "store")
    result = batch_campaigns([copied], BatchOptions(jobs=2, report=False, idle_timeout_s=5.0))
    found = by_name(result)
    lost = ("waits", "computes", "stands")
    assert {name: outcome.state for name, outcome in found.items()} == {
        "a": "held",
        "b": "held",
        **dict.fromkeys(lost, "lost"),
    }
    assert result.counts == BatchCounts(campaigns=5, held=2, not_held=0, broken=3, unchanged=1)
    for name in lost:
        outcome = found[name]
        assert outcome.error is not None
        assert (outcome.error.code, outcome.error.file) == (FaultCode.PLUGIN_FAILED, "own.py")
        assert "made no progress for 5 s" in outcome.error.reason
        assert (outcome.failed_at, list(outcome.steps)) == ("identify", ["ingest"])
        # once: a second try would only wait as long again
        assert len((copied / name / "pids").read_text().splitlines()) == 1
        assert not alive(int((copied / name / "pids").read_text()))


@pytest.mark.usefixtures("in_this_process")
def test_as_many_processes_as_cores(cells: Path) -> None:
    assert batch_campaigns([cells], BatchOptions(report=False)).workers == BatchWorkers(
        kind="processes", count=min(cores(), 3)
    )


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    # A process that has ended and whose parent has not asked yet counts as ended.
    status = Path(f"/proc/{pid}/stat")
    return not status.exists() or status.read_text().rpartition(")")[2].split()[0] != "Z"


@pytest.mark.skipif(sys.platform == "win32", reason="signals are another matter there")
def test_ctrl_c_ends_all_processes_and_the_next_call_goes_on(copied: Path) -> None:
    waiting = with_plugin(copied / "b", "if not (HERE / 'go').exists():\n    time.sleep(600)\n")
    shutil.rmtree(copied / "broken")
    command = [sys.executable, "-m", "stiffcal", "batch", str(copied), "--no-report", "--jobs", "2"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, process_group=0) as process:
        # Whatever goes wrong ends the test: the pipe closes, and the reading below with it.
        watch = threading.Timer(LONGEST_S, os.killpg, (process.pid, signal.SIGKILL))
        watch.start()
        try:
            assert process.stderr is not None
            # One campaign is done and the other waits, in whichever order, and whatever else is printed meanwhile.
            before = list(until(process.stderr, "cells/a: done"))
            until_it_exists(waiting / "pids", process)
            os.killpg(process.pid, signal.SIGINT)
            error = "".join(before) + process.stderr.read()
            process.wait()
        finally:
            watch.cancel()
    assert process.returncode == 130, error
    assert "1 of 2 campaigns are done; the same command continues with the rest" in error
    assert "Traceback" not in error
    assert not any(alive(int(pid)) for pid in (waiting / "pids").read_text().split())
    (waiting / "go").touch()
    found = by_name(batch_campaigns([copied], BatchOptions(jobs=1, report=False)))
    assert {outcome.state for outcome in found.values()} == {"held"}
    assert (done(found["a"]), done(found["b"])) == ([], ["identify", "validate"])


@pytest.mark.skipif(sys.platform == "win32", reason="signals are another matter there")
@pytest.mark.parametrize("sent", ["SIGTERM", "SIGHUP"])
def test_whatever_asks_the_command_to_end_does_what_ctrl_c_does(sent: str) -> None:
    number = getattr(signal, sent)
    before = signal.signal(number, signal.SIG_DFL)
    try:
        with pytest.raises(KeyboardInterrupt), ended_in_order():
            signal.raise_signal(number)
        assert signal.getsignal(number) is signal.SIG_DFL
        signal.signal(number, signal.SIG_IGN)
        with ended_in_order():
            signal.raise_signal(number)
    finally:
        signal.signal(number, before)


def until(stream: IO[str], words: str) -> Iterator[str]:
    """Read lines up to the first that holds some words."""
    for line in stream:
        yield line
        if words in line:
            return
    raise AssertionError(f"the process ended without: {words}")


def until_it_exists(file: Path, process: subprocess.Popen[str]) -> None:
    """Wait for a whole line in a file that a process writes."""
    while not (file.exists() and file.read_text().endswith("\n")):
        assert process.poll() is None, "the process ended before it wrote"
        time.sleep(0.02)
