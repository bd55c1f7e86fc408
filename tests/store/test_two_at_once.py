"""Two at once on one store: one waits or is refused; what either has written stays, and nothing is of both."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.stages.fit import fit_now, store_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.store import Store
from tests.laboratory.small_campaign import write_small_campaign

REPORTED = "is writing to it"
"""What a second writer hears when the first has not ended after twenty seconds, as on a machine that is very busy."""


def start(*words: str | Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "stiffcal", *map(str, words), "--json"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended_well_or_reported(process: subprocess.Popen[str]) -> int:
    """Wait for a command; return its exit code, 0, or 2 where it was refused because another one writes."""
    out, error = process.communicate(timeout=240)
    assert "Traceback" not in error
    document = json.loads(out)
    assert process.returncode == 0 or (process.returncode == 2 and REPORTED in document["error"]["reason"]), out + error
    return process.returncode


def test_three_commands_at_once_on_a_new_campaign(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)
    running = [start(word, folder) for word in ("ingest", "validate", "validate")]
    codes = [ended_well_or_reported(process) for process in running]
    assert 0 in codes
    validate_campaign(folder)
    store = Store(folder / "store")
    with store.snapshot() as snapshot:
        tables = {name: snapshot.read_table(name).num_rows for name in snapshot.tables}
        documents = {name: snapshot.read_document(name) for name in snapshot.documents}
    assert tables["states"] == tables["fit"] == tables["unseen"] > 0
    # Each fit that was made stands in the history once, by either process; the last one is validated.
    ids = [entry["id"] for entry in documents["history"]["fits"]]
    assert ids == [str(number + 1) for number in range(len(ids))]
    assert documents["identify"]["fit_id"] == ids[-1]
    # What each says is of the same fit, or is made anew on the next call: never taken for something it is not.
    said: list[str] = []
    document = validate_campaign(folder, RunContext(notify=said.append))
    assert document.fit_id == identify_campaign(folder).fit_id
    assert len(list((folder / "store" / "generations").iterdir())) == 1


def test_no_fit_of_two_that_end_together_is_lost_from_the_history(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)
    data = up_to_date_states(folder, RunContext())
    fit = fit_now(data, "linear", RunContext())
    together = threading.Barrier(3)
    begin = Store.begin

    def begin_together(store: Store, command: str = "stiffcal", wait_s: float = 20.0) -> object:
        # All have done all their thinking by now.
        together.wait(30)
        return begin(store, command, wait_s)

    monkeypatch.setattr(Store, "begin", begin_together)
    losses = ("linear", "huber", "linear")
    threads = [threading.Thread(target=store_fit, args=(data, fit, loss)) for loss in losses]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    fits = data.store.read_document("history")["fits"]
    # The third is the first one's fit once more, unless the other has come between.
    assert [entry["id"] for entry in fits] == [str(number + 1) for number in range(len(fits))]
    assert {entry["loss"] for entry in fits} == {"linear", "huber"}
