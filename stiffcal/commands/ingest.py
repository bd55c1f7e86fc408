"""Raw logs and tables → the store: load states, recordings, what was done to them, and from which files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.documents import Origin
    from stiffcal.ingest.results import IngestResult
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.store import Store


def ingest_campaign(
    folder: str | Path, store: str | Path | None = None, progress: Progress = no_progress
) -> IngestResult:
    """Turn the logs of a campaign into load states in its store.

    Parameters
    ----------
    folder : the campaign folder.
    store : where the store is; default ``folder/store``.
    progress : called with what is being read.

    Returns
    -------
    IngestResult
        What was made of each run, now or, where nothing has changed since, the last time.

    Raises
    ------
    InputError
        The campaign or one of its files is wrong; the store is then untouched.
    """
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.campaign.manifest.found_runs import unpartnered_remarks
    from stiffcal.ingest.freshness import freshness_of
    from stiffcal.ingest.ingesting import ingest_now
    from stiffcal.ingest.parts import INGEST
    from stiffcal.ingest.results import IngestResult
    from stiffcal.stages.stored import stored_result
    from stiffcal.store.index import FOREIGN, DamagedStoreError

    folder = Path(folder)
    campaign = load_campaign(folder)
    remarks = unpartnered_remarks(campaign.manifest, campaign.found)
    target = _store_of(folder, store)
    fresh = freshness_of(campaign, target)
    try:
        stored = None if fresh.reason else stored_result(target, INGEST, IngestResult)
    except DamagedStoreError as error:  # an answer of another shape, as an unreleased version may have written it
        if fresh.missing:
            raise
        return _with(remarks, ingest_now(campaign, target, f"the store is damaged: {error.faults[0].reason}", progress))
    if stored is None:
        return _with(remarks, ingest_now(campaign, target, fresh.changed, progress))
    if fresh.origin != FOREIGN:
        target.remove_leftovers()
    return _with(remarks, replace(stored, unchanged=True, changed="", origin=cast("Origin", fresh.origin)))


def _with(remarks: list[str], result: IngestResult) -> IngestResult:
    """Return a result with warnings on files that no store holds, as they are now."""
    return replace(result, warnings=[*remarks, *result.warnings])


def is_stale(folder: str | Path, store: str | Path | None = None) -> str:
    """Return why the store does not hold what the campaign's files state now, "" where it does."""
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.ingest.freshness import freshness_of, with_stored_runs

    folder = Path(folder)
    target = _store_of(folder, store)
    fresh = freshness_of(with_stored_runs(load_campaign(folder, check_files=False), target), target)
    return fresh.reason or (f"missing: {', '.join(fresh.missing)}" if fresh.missing else "")


def stored_states(
    folder: str | Path, store: str | Path | None = None, progress: Progress = no_progress, update: bool = True
) -> LoadStates:
    """Return the campaign's load states, ingesting first where they are missing or stale.

    Parameters
    ----------
    update : False: refuse instead of ingesting (``--no-update``).

    Raises
    ------
    InputError
        The campaign is wrong, or the store is stale and may not be updated.
    """
    from stiffcal.stages.steps import stored_table

    folder = Path(folder)
    reason = is_stale(folder, store)
    if reason:
        if not update:
            raise InputError.at(
                FaultCode.STORE_OUTDATED,
                str(store or folder / "store"),
                "",
                f"out of date ({reason})",
                "run ingest first",
            )
        ingest_campaign(folder, store, progress)
    target = _store_of(folder, store)
    return stored_table(target)[1]


def _store_of(folder: Path, store: str | Path | None) -> Store:
    from stiffcal.stages.steps import RunContext, open_store

    return open_store(folder, RunContext(store=None if store is None else str(store)))
