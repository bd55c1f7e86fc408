"""Many campaigns in one go: ingest, identify, validate and report each, in parallel, with one summary."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault, InputError, Progress, no_progress
from stiffcal.escapes.file_name import with_short_name
from stiffcal.fault_codes import FaultCode
from stiffcal.masking import masked
from stiffcal.results.batch_results import (
    BROKEN,
    HELD,
    IDLE_TIMEOUT_S,
    NOT_HELD,
    BatchCounts,
    BatchResult,
    BatchTask,
    BatchWorkers,
    CampaignOutcome,
    outcome_of,
)

if TYPE_CHECKING:
    from stiffcal.campaign.manifest.thresholds import ThresholdsFile

NOT_SEARCHED = frozenset({"store", "raw", "node_modules", "__pycache__"})


def no_outcome(outcome: CampaignOutcome, done: int, of: int) -> None:
    """Let an outcome pass; the default of `BatchOptions.finished`."""


@dataclass(frozen=True)
class BatchOptions:
    """How a batch is to be run."""

    jobs: int | None = None
    """Processes on this machine; None: one per core that this process may use."""
    thresholds: Path | None = None
    """A file of thresholds, which the manifests may only tighten."""
    store: str | None = None
    """The address below which the stores are, each under its campaign's name; None: DIR/store."""
    reports: Path | None = None
    """The folder for the PDFs, each under its campaign's name; None: DIR/report.pdf."""
    report: bool = True
    """False: no PDFs."""
    scheduler: str | None = None
    """The address of a Dask cluster that is to do the work; None: this machine."""
    idle_timeout_s: float = IDLE_TIMEOUT_S
    """After so long without progress a campaign's process is given up, s."""
    overwrite: bool = False
    """Also write PDFs over files that hold something stiffcal did not write."""
    progress: Progress = no_progress
    """Called with what is being done."""
    finished: Callable[[CampaignOutcome, int, int], None] = no_outcome
    """Called with each campaign's outcome, the number of outcomes so far and the number of campaigns."""


def batch_campaigns(folders: Sequence[Path], options: BatchOptions | None = None) -> BatchResult:
    """Run ingest, identify, validate and report on many campaigns.

    What has not changed since the last time is not computed again. A campaign that is wrong, or whose process is
    killed twice or makes no progress, is named in the summary and does not stop the others.

    Parameters
    ----------
    folders : campaign folders, or folders in which campaign folders are looked for.
    options : how.

    Returns
    -------
    BatchResult
        What came of each campaign, in the order given.

    Raises
    ------
    InputError : no campaign is found, or the thresholds or the scheduler are wrong.
    KeyboardInterrupt : the user wants no more; every store is whole, and the same call goes on where this one stopped.
    """
    options = options or BatchOptions()
    began = time.monotonic()
    file = _thresholds(options.thresholds) if options.thresholds is not None else None
    listed, absent = find_campaigns(folders)
    tasks = _tasks(listed, folders, options, file)
    outcomes = {absent_folder.folder: absent_folder for absent_folder in absent}

    def take(outcome: CampaignOutcome) -> None:
        # What a worker's process or a cluster wrote of itself stands in these as it came.
        outcome = replace(
            outcome,
            error=masked(outcome.error),
            others=masked(outcome.others),
            warnings=masked(outcome.warnings),
            choices=masked(outcome.choices),
        )
        outcomes[outcome.folder] = outcome
        done = len(outcomes) - len(absent)
        options.progress(f"{done} of {len(tasks)} campaigns: {outcome.campaign}", done / len(tasks))
        options.finished(outcome, done, len(tasks))

    options.progress(f"{len(tasks)} campaigns", 0.0)
    # The largest first: none of them is then left over at the end while the other cores have nothing to do.
    queue = sorted(tasks, key=lambda task: _bytes_of(Path(task.folder)), reverse=True)
    if options.scheduler is not None:
        from stiffcal.batch.cluster import run_on_cluster

        workers = BatchWorkers(kind="dask", count=run_on_cluster(queue, options.scheduler, take))
    else:
        from stiffcal.batch.processes import run_on_this_machine

        jobs = min(options.jobs or cores(), len(queue))
        workers = BatchWorkers(kind="processes", count=jobs)
        run_on_this_machine(queue, jobs, take)
    ordered = [outcomes[task.folder] for task in tasks] + absent
    return _result(ordered, workers, time.monotonic() - began, _unused(file, ordered))


def _thresholds(file: Path) -> ThresholdsFile:
    from stiffcal.campaign.manifest.thresholds import load_thresholds

    return load_thresholds(file)


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def find_campaigns(folders: Sequence[Path]) -> tuple[list[tuple[Path, str]], list[CampaignOutcome]]:
    """Find the campaign folders: those named, and those inside of folders that are none themselves.

    Returns
    -------
    Folder and label of each, once, in the order given; and the outcome of what is no campaign folder.

    Raises
    ------
    InputError : there is none at all.
    """
    by_path: dict[Path, tuple[Path, str]] = {}
    absent: list[CampaignOutcome] = []
    faults: list[Fault] = []
    for folder_given in folders:
        inside = [folder_given] if (folder_given / MANIFEST_FILE).is_file() else sorted(_below(folder_given))
        for folder in inside:
            label = Path(folder_given.resolve().name, folder.relative_to(folder_given)).as_posix()
            by_path.setdefault(folder.resolve(), (folder, label))
        if not inside:
            reason = f"there is no {MANIFEST_FILE} in it" if folder_given.is_dir() else "no such folder"
            fault = Fault(FaultCode.FILE_MISSING, str(folder_given), "", reason, "give a campaign folder")
            faults.append(fault)
            absent.append(outcome_of(BatchTask(folder=str(folder_given), campaign=str(folder_given)), BROKEN, fault))
    if not by_path:
        mend = "give a campaign folder, or a folder that contains campaign folders"
        raise InputError.at(FaultCode.FILE_MISSING, faults[0].file, "", faults[0].reason, mend)
    twice = Counter(label for _, label in by_path.values())
    return [
        (folder, label if twice[label] == 1 else whole.as_posix().strip("/"))
        for whole, (folder, label) in by_path.items()
    ], absent


def _below(named: Path) -> list[Path]:
    """Return the campaign folders below one; not those inside of another campaign's folder."""
    campaigns = []
    for place, names, files in os.walk(named):
        if MANIFEST_FILE in files:
            campaigns.append(Path(place))
            names.clear()
        names[:] = [name for name in names if name not in NOT_SEARCHED and not name.startswith(".")]
    return campaigns


def _tasks(
    listed: Sequence[tuple[Path, str]], user_paths: Sequence[Path], options: BatchOptions, file: ThresholdsFile | None
) -> list[BatchTask]:
    """Return the task of every campaign.

    Parameters
    ----------
    listed : folder and label of each campaign.
    user_paths : the folders that the user named; manifests may point to baselines in them.
    options : how the batch is to be run.
    file : the thresholds, whose baselines a manifest may point to as well; None where there are none.
    """
    allowed_paths = [str(path.resolve()) for path in (*user_paths, *(file.baselines() if file is not None else ()))]
    thresholds = None if file is None else file.model_dump(mode="json", by_alias=True, exclude_none=True)
    local, tasks = options.scheduler is None, []
    for folder, label in listed:
        report_file = None
        if options.report and options.reports is not None:
            report_file = str((options.reports / with_short_name(label, ".pdf")).resolve())
        store = store_below(options.store, label) if options.store is not None else None
        # A cluster's workers have another current folder: they need the whole path.
        worker_path = folder if local else folder.resolve()
        tasks.append(
            BatchTask(
                folder=str(worker_path),
                campaign=label,
                store=store,
                report=options.report,
                report_file=report_file,
                overwrite=options.overwrite,
                thresholds=thresholds,
                allowed_paths=allowed_paths,
                idle_timeout_s=options.idle_timeout_s,
            )
        )
    return tasks


def store_below(store: str, label: str) -> str:
    """Return where the store of one campaign is, of stores that are all below one address.

    Examples
    --------
    >>> store_below("build/stores", "cells/a b"), store_below("s3://lab/stores/", "cells/50 %")
    ('build/stores/cells/a b', 's3://lab/stores/cells/50%20%25')
    """
    return f"{store.rstrip('/')}/{quote(label, errors='surrogateescape') if '://' in store else label}"


def _bytes_of(folder: Path) -> int:
    """Return about how much there is to read."""
    raw = folder / "raw"
    return sum(file.stat().st_size for file in raw.iterdir() if file.is_file()) if raw.is_dir() else 0


def _unused(file: ThresholdsFile | None, outcomes: Sequence[CampaignOutcome]) -> list[str]:
    if file is None:
        return []
    outcome_names = {name for outcome in outcomes for name in (outcome.name, Path(outcome.folder).resolve().name)}
    return [
        f"the thresholds of {name} belong to no campaign in this batch"
        for name in file.campaigns
        if name not in outcome_names
    ]


def _result(outcomes: list[CampaignOutcome], workers: BatchWorkers, seconds: float, warnings: list[str]) -> BatchResult:
    memory = [outcome.memory_bytes for outcome in outcomes if outcome.memory_bytes]
    return BatchResult(
        warnings=warnings,
        passed=all(outcome.state == HELD for outcome in outcomes),
        counts=BatchCounts(
            campaigns=len(outcomes),
            held=sum(outcome.state == HELD for outcome in outcomes),
            not_held=sum(outcome.state == NOT_HELD for outcome in outcomes),
            broken=sum(outcome.state not in (HELD, NOT_HELD) for outcome in outcomes),
            unchanged=sum(outcome.unchanged for outcome in outcomes),
        ),
        seconds=round(seconds, 3),
        workers=workers,
        peak_memory_bytes=max(memory, default=None),
        campaigns=outcomes,
    )
