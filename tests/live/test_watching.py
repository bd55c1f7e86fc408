"""Logs that come while the server runs: runs appear, what is half written is no fault, what is broken has its line."""

from __future__ import annotations

import http.client
import json
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.errors import InputError
from stiffcal.live.choice import ModelChoice
from stiffcal.live.log_files import QUIET_S, SETTLED_S, LogFiles
from stiffcal.live.models import LiveModels
from stiffcal.live.page import live_server
from stiffcal.live.watching import LogWatcher, WatchedRun
from stiffcal.reduction.logs import log_rows as logs
from stiffcal.reduction.states import tabled_states
from stiffcal.stages.steps import RunContext
from stiffcal.view.packing import unpacked
from tests.laboratory.small_campaign import CAMPAIGN, write_small_campaign
from tests.long_campaigns.campaign import write_head, write_runs

OLD_S = 10.0 * QUIET_S


class Measuring:
    """A campaign whose logs come one by one, and its clock.

    Attributes
    ----------
    folder : of the campaign. logs : the text of each run's log, by run. now : seconds.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = write_small_campaign(folder)
        table = folder / "raw" / "states.csv"
        head, *rows = table.read_text().splitlines(keepends=True)
        self.logs = {
            f"pose{k}": head + "".join(row for row in rows if row.startswith(f"pose{k},")) for k in range(1, 5)
        }
        table.unlink()
        self.manifest = CAMPAIGN.replace('run = { column = "run" }\n', "").replace("states.csv", "{run}.csv")
        (folder / "campaign.toml").write_text(self.manifest)
        self.now = 1.0e9
        self.context = RunContext()
        self.models = LiveModels(folder, self.context)
        self.watcher = LogWatcher(folder, self.models, LogFiles(folder, lambda: self.now, lambda: self.now))

    def write(self, run: str, text: str, mode: str = "a") -> None:
        """Write to a run's log at the clock's time."""
        path = self.folder / "raw" / f"{run}.csv"
        with path.open(mode, encoding="utf-8") as file:
            file.write(text)
        os.utime(path, (self.now, self.now))

    def runs(self, later: float = 0.0) -> dict[str, WatchedRun]:
        """Look some time later; return the runs as they are then."""
        self.watcher.look()
        if later:
            self.now += later
            self.watcher.look()
        return {run.id: run for run in self.watcher.seen.runs}

    @property
    def version(self) -> int:
        return self.watcher.seen.version


@pytest.fixture
def measuring(tmp_path: Path) -> Iterator[Measuring]:
    made = Measuring(tmp_path / "c")
    yield made
    made.watcher.close()


def shown_states(measuring: Measuring) -> int:
    return measuring.models.content(ModelChoice()).n_states


def test_runs_appear_as_their_logs_come_in_pieces(measuring: Measuring) -> None:
    assert measuring.runs() == {}
    assert measuring.version == 0
    text = measuring.logs["pose1"]
    for end in (40, 400, 700):  # in the middle of a line each time
        measuring.write("pose1", text[:end], "w")
        (run,) = measuring.runs(2.0 * SETTLED_S).values()
        assert run.stage == "waiting"
    measuring.write("pose1", text, "w")
    assert measuring.runs()["pose1"].stage == "waiting"
    run = measuring.runs(SETTLED_S)["pose1"]
    assert (run.stage, run.n_states, measuring.version) == ("read", 25, 1)
    measuring.write("pose2", measuring.logs["pose2"])
    assert measuring.runs()["pose2"].stage == "waiting"
    assert measuring.version == 1
    assert measuring.runs(SETTLED_S)["pose2"].stage == "read"
    assert measuring.version == 2
    assert shown_states(measuring) == 50
    measuring.runs(OLD_S)
    assert measuring.version == 2  # nothing has come


def test_what_holds_for_all_runs_is_stated_once(measuring: Measuring) -> None:
    unused = '\n[frames.unused]\nparent = "flange"\nxyz_m = [0.0, 0.0, 0.1]\n'
    (measuring.folder / "campaign.toml").write_text(measuring.manifest + unused)
    measuring.write("pose1", measuring.logs["pose1"])
    (run,) = measuring.runs(SETTLED_S).values()
    assert [sum("frames.unused" in line for line in lines) for lines in (measuring.watcher.seen.lines, run.lines)] == [
        1,
        0,
    ]


def test_a_run_that_was_read_is_not_read_again(measuring: Measuring, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []

    def noted(folder: Path, name: str, source: Any, files: Any, *rest: Any) -> Any:
        read.extend(files.values())
        return logs.read_rows(folder, name, source, files, *rest)

    monkeypatch.setattr(tabled_states, "read_rows", noted)
    for k in range(1, 4):
        read.clear()
        measuring.write(f"pose{k}", measuring.logs[f"pose{k}"])
        measuring.runs(SETTLED_S)
        assert set(read) == {f"raw/pose{k}.csv"}
    assert shown_states(measuring) == 75


def test_what_is_shown_is_what_the_commands_make(measuring: Measuring) -> None:
    for run in ("pose1", "pose2", "pose3"):
        measuring.write(run, measuring.logs[run])
    measuring.runs(SETTLED_S)
    before = set(measuring.folder.rglob("*"))
    content = measuring.models.content(ModelChoice())
    tried = measuring.models.content(ModelChoice(added=["bearing-tilt j2"]))
    assert set(measuring.folder.rglob("*")) == before  # all of it is kept elsewhere
    present = next(model for model in content.models if model.present)
    fitted = identify_campaign(measuring.folder)
    assert present.fit_rms == fitted.rms
    assert content.n_states == fitted.n_states
    assert tried.live is not None
    assert tried.live.added == ["bearing-tilt j2"]


def test_a_diagnosis_of_the_logs_before_stands_until_the_next_one(measuring: Measuring) -> None:
    model = measuring.folder / "model.toml"
    model.write_text(model.read_text("utf-8").replace("4, 5, 6]", "4, 5]"), encoding="utf-8")
    measuring.models.reload()
    for run in ("pose1", "pose2"):
        measuring.write(run, measuring.logs[run])
    measuring.runs(SETTLED_S)
    judged = measuring.models.diagnose(ModelChoice())
    assert judged.candidates
    assert judged.diagnosis_of == ""
    measuring.write("pose3", measuring.logs["pose3"])
    measuring.runs(SETTLED_S)
    for choice in (ModelChoice(), ModelChoice(added=[judged.candidates[0].name])):
        later = measuring.models.content(choice)
        assert later.n_states > judged.n_states
        assert later.diagnosis_of != ""
        assert [one.name for one in later.candidates] == [one.name for one in judged.candidates]
    # of another model it says nothing
    model.write_text(model.read_text("utf-8").replace("4, 5]", "4]"), encoding="utf-8")
    measuring.write("pose4", measuring.logs["pose4"])
    measuring.runs(SETTLED_S)
    assert measuring.models.content(ModelChoice()).diagnosis_of == ""


def test_rows_that_are_appended_are_read_too(measuring: Measuring) -> None:
    for run in ("pose1", "pose2"):
        measuring.write(run, measuring.logs[run])
    lines = measuring.logs["pose3"].splitlines(keepends=True)
    measuring.write("pose3", "".join(lines[:11]))
    assert measuring.runs(SETTLED_S)["pose3"].n_states == 10
    assert shown_states(measuring) == 60
    measuring.write("pose3", "".join(lines[11:]))
    assert measuring.runs()["pose3"].stage == "waiting"
    assert shown_states(measuring) == 60
    assert measuring.runs(SETTLED_S)["pose3"].n_states == 25
    assert shown_states(measuring) == 75


def test_a_broken_log_has_its_line_and_the_others_stay(measuring: Measuring) -> None:
    for run in ("pose1", "pose2"):
        measuring.write(run, measuring.logs[run])
    lines = measuring.logs["pose3"].splitlines(keepends=True)
    measuring.write("pose3", "".join([*lines[:5], lines[5].replace(",", ",x", 1), *lines[6:]]))
    assert measuring.runs(SETTLED_S)["pose3"].stage == "waiting"  # somebody may still write it
    found = measuring.runs(QUIET_S)["pose3"]
    assert found.stage == "faulty"
    assert any("raw/pose3.csv" in line and "line 6" in line for line in found.lines)
    assert shown_states(measuring) == 50
    measuring.write("pose3", measuring.logs["pose3"], "w")
    assert measuring.runs(SETTLED_S)["pose3"].stage == "read"
    assert shown_states(measuring) == 75


def test_a_log_without_a_last_line_s_end_is_never_a_fault(measuring: Measuring) -> None:
    measuring.write("pose1", measuring.logs["pose1"])
    measuring.write("pose2", measuring.logs["pose2"].replace("\n", ",note\n").rstrip("\n"))
    measuring.write("pose3", measuring.logs["pose3"][:600])
    assert measuring.runs(SETTLED_S)["pose2"].stage == "waiting"
    runs = measuring.runs(QUIET_S)
    assert (runs["pose2"].stage, runs["pose2"].n_states) == ("read", 25)  # nothing that is read can be cut
    assert runs["pose3"].stage == "waiting"


def test_a_log_that_was_taken_away_is_shown_no_more(measuring: Measuring) -> None:
    for run in ("pose1", "pose2", "pose3"):
        measuring.write(run, measuring.logs[run])
    measuring.runs(SETTLED_S)
    assert shown_states(measuring) == 75
    (measuring.folder / "raw" / "pose3.csv").unlink()
    assert set(measuring.runs()) == {"pose1", "pose2"}
    assert shown_states(measuring) == 50


def test_a_log_without_its_partner_waits_for_it(tmp_path: Path) -> None:
    """Of two devices one has written its log of a run: it is no run yet, and no fault."""
    folder = tmp_path / "c"
    write_head(folder)
    write_runs(folder, 1, 3)
    partner = folder / "raw" / "run2_log.csv"
    text = partner.read_text(encoding="utf-8")
    partner.unlink()
    context = RunContext()
    watcher = LogWatcher(folder, LiveModels(folder, context), LogFiles(folder))
    try:
        for file in (folder / "raw").iterdir():
            os.utime(file, (0.0, 0.0))  # nobody writes them any more
        watcher.look()
        assert {run.id: run.stage for run in watcher.seen.runs} == {"run1": "read", "run2": "waiting"}
        assert not any("run2" in line for line in watcher.seen.lines)
        partner.write_text(text, encoding="utf-8")
        os.utime(partner, (0.0, 0.0))
        watcher.look()
        assert {run.id: run.stage for run in watcher.seen.runs} == {"run1": "read", "run2": "read"}
    finally:
        watcher.close()


def test_a_manifest_that_is_being_edited_ends_nothing(measuring: Measuring) -> None:
    measuring.write("pose1", measuring.logs["pose1"])
    measuring.write("pose2", measuring.logs["pose2"])
    measuring.runs(SETTLED_S)
    manifest = measuring.folder / "campaign.toml"
    manifest.write_text(measuring.manifest.replace("[sources.table]", "[sources.tab"))
    measuring.watcher.look()
    assert any("campaign.toml" in line for line in measuring.watcher.seen.lines)
    assert measuring.version == 1
    manifest.write_text(measuring.manifest)
    measuring.watcher.look()
    assert not any("campaign.toml" in line for line in measuring.watcher.seen.lines)


def test_one_table_that_grows_is_read_again(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "c")
    table = folder / "raw" / "states.csv"
    lines = table.read_text().splitlines(keepends=True)
    now = [1.0e9]
    models = LiveModels(folder, RunContext())
    watcher = LogWatcher(folder, models, LogFiles(folder, lambda: now[0], lambda: now[0]))

    def written(count: int) -> int:
        table.write_text("".join(lines[: 1 + count]))
        os.utime(table, (now[0], now[0]))
        watcher.look()
        now[0] += SETTLED_S
        watcher.look()
        return models.content(ModelChoice()).n_states

    assert written(50) == 50
    assert written(75) == 75
    assert watcher.seen.version == 2
    assert [(run.id, run.stage) for run in watcher.seen.runs] == [("", "read")]
    watcher.close()


def test_a_folder_that_is_no_campaign_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        live_server(tmp_path, RunContext(), watch=True)


def test_the_server_tells_the_page_under_the_same_rules(tmp_path: Path) -> None:
    measuring = Measuring(tmp_path / "c")
    measuring.watcher.close()
    server = live_server(measuring.folder, RunContext(), watch=True)
    watcher = server.background
    assert isinstance(watcher, LogWatcher)
    thread = threading.Thread(target=server._http.serve_forever)  # without the thread that looks: the test looks itself
    thread.start()

    def ask(name: str, token: str, document: Any) -> tuple[int, str]:
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
        headers = {"X-Stiffcal-Token": token, "Content-Type": "application/json"}
        connection.request("POST" if name else "GET", f"/{name}" if name else f"/?token={token}",
                           json.dumps(document) if name else None, headers)  # fmt: skip
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        return answer.status, text

    try:
        assert ask("watched", "x" * 43, {})[0] == 403
        status, text = ask("", server.token, {})
        assert (status, 'id="data"' in text) == (200, False)  # nothing to show yet: the page waits
        for run in ("pose1", "pose2"):
            measuring.now = 0.0  # long ago
            measuring.write(run, measuring.logs[run])
        measuring.write("pose3", "<script>alert(1)</script>\n")
        watcher.look()
        status, text = ask("watched", server.token, {})
        answer = json.loads(text)
        assert (status, answer["version"]) == (200, 1)
        stages = {run["id"]: run["stage"] for run in answer["runs"]}
        assert (stages["pose1"], stages["pose2"]) == ("read", "read")
        assert "faulty" in stages.values()
        status, text = ask("", server.token, {})
        assert 'id="data"' in text
        assert "<script>alert" not in text
        status, text = ask("content", server.token, {"choice": {"added": ["bearing-tilt j2"]}})
        assert unpacked(text)[0]["n_states"] == 50
    finally:
        server._http.shutdown()
        thread.join()
        server.close()
