"""Raw logs and tables → the store: load states, recordings, what was done to them, and from which files."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stiffcal.documents import document_of
from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.parts import INGEST, PROVENANCE, STATES, is_needed
from stiffcal.ingest.sources import files_in_order_of_runs, ingest_settings, sources_elsewhere

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.ingest.results import IngestResult
    from stiffcal.store import SourceFile, Store


def ingest_now(
    campaign: Campaign, target: Store, changed: str, progress: Progress = no_progress, thorough: bool = False
) -> IngestResult:
    """Bring a store up to date, whatever it holds; logs of runs that are as they were are not read again.

    Parameters
    ----------
    campaign : as it was read, its files checked.
    target : the store, written only where all of the logs could be read.
    changed : why, for the result; "" where nothing was ingested before.
    progress : called with what is being read.
    thorough : hash all logs, whatever the file system's data on them.

    Returns
    -------
    IngestResult

    Raises
    ------
    InputError : one of the files is wrong; the states in the store are then untouched.
    """
    result = None
    while result is None:
        result = _read_on(campaign, target, changed, progress, thorough)
    return replace(result, origin="own")


def _read_on(
    campaign: Campaign, target: Store, changed: str, progress: Progress, thorough: bool
) -> IngestResult | None:
    """Read runs that the store does not hold yet, all of them, or, where that takes long, as many as to keep at once.

    Returns
    -------
    The result; None where runs remain: the states in the store are still those of before.
    """
    from stiffcal.ingest.reading import run_readings
    from stiffcal.ingest.reading.reducing import reduce_campaign
    from stiffcal.measurements.tables import states_table
    from stiffcal.store import Provenance, hash_sources
    from stiffcal.store.index import OWN

    files, settings = files_in_order_of_runs(campaign), ingest_settings(campaign)
    outside = sources_elsewhere(campaign)
    with target.begin("ingest") as writing:
        with run_readings.open_readings(target) as stored:
            states = {} if thorough else stored.states
            with hash_sources(campaign.folder, files, stored.sources, states) as hashes:
                # what somebody else has written goes with the first commit: only once all logs could be read
                seconds = run_readings.CHECKPOINT_S if target.origin_of(STATES) == OWN else math.inf
                readings = run_readings.RunReadings(
                    campaign, stored, lambda file: hashes.of(file).sha256, outside, seconds
                )
                try:
                    reduced = reduce_campaign(campaign, progress, writing, readings)
                except run_readings.ReadingPaused:
                    readings.write(writing, hashes.finished(), hashes.states, paused=True)
                    writing.keep_rest()
                    reduced = None
                else:
                    progress("hashing the sources", None)
                    if outside != sources_elsewhere(campaign):
                        raise _rows_changed(outside)
                    sources = hashes.result()
                    readings.write(writing, sources, hashes.states)
                    writing.sources_state = hashes.state
        if reduced is None:
            writing.commit()
            return None
        result = replace(reduced.result, changed=changed)
        writing.write_table(
            STATES, states_table(reduced.states, campaign.chain.joint_names, campaign.chain.prismatic_names)
        )
        for name, table in reduced.non_load.tables(settings).items():
            writing.write_table(name, table)
        writing.write_document(INGEST, document_of(result))
        provenance = Provenance.now("ingest", (*sources, *outside), document_of(settings))
        writing.write_document(PROVENANCE, document_of(provenance))
        _keep_what_others_wrote(writing, target.tables, target.documents)
        writing.commit()
    return result


def _rows_changed(outside: tuple[SourceFile, ...]) -> InputError:
    names = ", ".join(source.file for source in outside)
    reason, mend = "the rows changed while they were read", "wait until nobody writes them"
    return InputError.at(FaultCode.FILE_CHANGED, names, "", reason, mend)


def _keep_what_others_wrote(writing: Any, tables: tuple[str, ...], documents: tuple[str, ...]) -> None:
    """Carry over history and fits: all that is not made from the logs alone; they hold from which states they come."""
    kept = [name for name in (*tables, *documents) if not is_needed(name)]
    writing.keep(*dict.fromkeys(kept))
