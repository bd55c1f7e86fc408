"""Raw logs and tables → the store: load states, recordings, what was done to them, and from which files."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stiffcal.documents import document_of
from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.experiments import tables_of_logs
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.parts import INGEST, PROVENANCE, RECORDINGS, STATES
from stiffcal.ingest.sources import ingest_settings, manifest_data_files, sources_elsewhere

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.ingest.results import IngestResult
    from stiffcal.store import Store


def ingest_now(campaign: Campaign, target: Store, changed: str, progress: Progress = no_progress) -> IngestResult:
    """Read the logs, whatever the store holds.

    Parameters
    ----------
    campaign : as it was read, its files checked.
    target : the store, written only where all of the logs could be read.
    changed : why, for the result; "" where nothing was ingested before.
    progress : called with what is being read.

    Returns
    -------
    IngestResult

    Raises
    ------
    InputError : one of the files is wrong; the store is then untouched.
    """
    from stiffcal.store import Provenance, hash_sources

    folder = campaign.folder
    files, settings = manifest_data_files(campaign), ingest_settings(campaign)
    outside = sources_elsewhere(campaign)
    from stiffcal.ingest.reducing import reduce_campaign
    from stiffcal.measurements.tables import states_table

    with hash_sources(folder, files) as hashes, target.begin("ingest") as writing:
        reduced = reduce_campaign(campaign, progress, writing)
        result = replace(reduced.result, changed=changed)
        writing.write_table(
            STATES, states_table(reduced.states, campaign.chain.joint_names, campaign.chain.prismatic_names)
        )
        for name, table in reduced.non_load.tables(settings).items():
            writing.write_table(name, table)
        writing.write_document(INGEST, document_of(result))
        progress("hashing the sources", None)
        if outside != sources_elsewhere(campaign):
            names = ", ".join(source.file for source in outside)
            raise InputError.at(
                FaultCode.FILE_CHANGED,
                names,
                "",
                "the rows changed while they were read",
                "wait until nobody writes them",
            )
        provenance = Provenance.now("ingest", (*hashes.result(), *outside), document_of(settings))
        writing.write_document(PROVENANCE, document_of(provenance))
        writing.sources_state = hashes.state
        _keep_what_others_wrote(writing, target.tables, target.documents)
        writing.commit()
    return replace(result, origin="own")


def _keep_what_others_wrote(writing: Any, tables: tuple[str, ...], documents: tuple[str, ...]) -> None:
    """Carry over history and fits; they hold themselves from which states they come."""
    kept = [name for name in tables if name not in (STATES, *tables_of_logs()) and not name.startswith(RECORDINGS)]
    kept += [name for name in documents if name not in (INGEST, PROVENANCE)]
    writing.keep(*dict.fromkeys(kept))
