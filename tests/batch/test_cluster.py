"""The same batch on a Dask cluster: a real scheduler and real workers on this machine, one of which is killed."""

from __future__ import annotations

import io
import json
import logging
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from stiffcal.batch.campaigns import BatchOptions, batch_campaigns
from stiffcal.batch.task import run_task
from stiffcal.errors import InputError
from stiffcal.extras import install_command
from stiffcal.results.batch_results import LOST, BatchTask, CampaignOutcome
from stiffcal.trust.record import open_record
from tests.batch.test_campaigns import LONGEST_S, by_name
from tests.laboratory.batch_plugins import PLUGIN, with_plugin
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.long

# The worker of stiffcal is a child of the worker of Dask, which is what dies here, the first time only.
KILL_THE_CLUSTERS_WORKER = """
if not (HERE / "killed").exists():
    (HERE / "killed").write_text(str(os.getppid()))
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(60)
"""


@contextmanager
def started(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def started_scheduler(folder: Path) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """A scheduler, and its address."""
    file = folder / "scheduler.json"
    words = ("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    with started(*words) as process:
        end = time.monotonic() + LONGEST_S
        # The scheduler makes the file, and then writes into it.
        while not (text := file.read_text() if file.exists() else "").rstrip().endswith("}"):
            assert process.poll() is None, "the scheduler ended before it wrote its address"
            assert time.monotonic() < end, "the scheduler never wrote its address"
            time.sleep(0.05)
        yield process, json.loads(text)["address"]


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A scheduler's address."""
    with started_scheduler(tmp_path_factory.mktemp("dask")) as (_, address):
        yield address


@contextmanager
def workers(scheduler: str, count: int) -> Iterator[list[subprocess.Popen[bytes]]]:
    words = ("dask_worker", scheduler, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0")
    if count == 0:
        yield []
        return
    with started(*words) as first, workers(scheduler, count - 1) as others:
        yield [first, *others]


def numbers(outcome: CampaignOutcome) -> tuple[Any, ...]:
    return outcome.state, outcome.rms, outcome.stiffness


def test_a_cluster_gives_the_same_and_a_killed_worker_costs_a_retry(scheduler: str, tmp_path: Path) -> None:
    cells = tmp_path / "cells"
    for seed, name in enumerate("abc"):
        write_small_campaign(cells / name, seed=seed, poses=2)
    with_plugin(cells / "b", "")
    # Alike but for what kills: the same model, the same plugin's name.
    here = Path(shutil.copytree(cells, tmp_path / "here"))
    open_record().allow_folder(here / "b")
    (cells / "b" / "own.py").write_text(PLUGIN + KILL_THE_CLUSTERS_WORKER)
    with workers(scheduler, 2) as running:
        result = batch_campaigns([cells], BatchOptions(scheduler=scheduler, report=False))
        killed = int((cells / "b" / "killed").read_text())
        assert killed in {worker.pid for worker in running}
        assert [worker.wait(LONGEST_S) for worker in running if worker.pid == killed] == [-signal.SIGKILL]
    assert result.workers.kind == "dask"
    found = by_name(result)
    for name in "abc":
        alone = run_task(BatchTask(folder=str(here / name), campaign=name, report=False))
        assert numbers(found[name]) == numbers(alone), name
    assert result.passed is True


def test_a_cluster_without_workers_or_without_a_scheduler(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stiffcal.batch.cluster.ANSWER_S", 1)
    write_small_campaign(tmp_path / "a", poses=2)
    with pytest.raises(InputError, match=r"the cluster at .* has no worker; start workers: dask worker"):
        batch_campaigns([tmp_path], BatchOptions(scheduler=scheduler))
    with pytest.raises(InputError, match=r"--scheduler: no Dask scheduler at tcp://127\.0\.0\.1:9"):
        batch_campaigns([tmp_path], BatchOptions(scheduler="tcp://127.0.0.1:9"))
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=re.escape(install_command("dask"))):
        batch_campaigns([tmp_path], BatchOptions(scheduler=scheduler))


def test_a_killed_scheduler_is_a_line_for_each_campaign_that_was_not_done(tmp_path: Path) -> None:
    logger, written = logging.getLogger("distributed.client"), io.StringIO()
    handler = logging.StreamHandler(written)
    logger.addHandler(handler)
    for name in "abc":
        write_small_campaign(tmp_path / "cells" / name, poses=2)
    with started_scheduler(tmp_path) as (process, address), workers(address, 1):
        options = BatchOptions(scheduler=address, report=False, finished=lambda *_: process.kill())
        result = batch_campaigns([tmp_path / "cells"], options)
    lost = [outcome for outcome in result.campaigns if outcome.state == LOST]
    assert lost
    assert all(outcome.error is not None and address in outcome.error.reason for outcome in lost)
    logger.removeHandler(handler)
    assert written.getvalue() == ""


def test_folders_that_a_cluster_does_not_see(tmp_path: Path) -> None:
    from stiffcal.batch.cluster import cluster_task

    outcome = cluster_task(BatchTask(folder=str(tmp_path / "elsewhere"), campaign="a"))
    assert outcome.state == "broken"
    assert outcome.error is not None
    assert "same path on every worker" in outcome.error.mend
