"""What a campaign's load states are made from: files, tables of a database, and settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.ingest.reading.run_keys import name_elsewhere
from stiffcal.revision import REVISION
from stiffcal.store.provenance import IngestSettings

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.store import SourceFile


def manifest_data_files(campaign: Campaign) -> list[str]:
    """Return every data file that the manifest names, as named there, each once."""
    manifest = campaign.manifest
    files: list[str] = []
    for name, source in manifest.sources.items():
        if not source.in_files:
            continue
        files += manifest.files_of(name).values()
        for run in manifest.runs:
            files += [run.files[name]] if name in run.files else []
    files += [run.states for run in manifest.runs if run.states is not None]
    return list(dict.fromkeys(files))


def files_in_order_of_runs(campaign: Campaign, only: str | None = None) -> list[str]:
    """Return the files that the runs name, those of each run side by side as they are read, then those of all runs.

    Parameters
    ----------
    only : leave out the files of other runs than this.
    """
    manifest = campaign.manifest
    in_files = {name for name, source in manifest.sources.items() if source.in_files}
    in_runs = [
        file
        for run in manifest.runs
        if only in (None, run.id)
        for file in (*(run.files[name] for name in run.files if name in in_files), run.states)
        if file is not None
    ]
    of_all = [file for name in manifest.sources if name in in_files for file in manifest.files_of(name).values()]
    return list(dict.fromkeys((*in_runs, *of_all)))


def sources_elsewhere(campaign: Campaign) -> tuple[SourceFile, ...]:
    """Return the tables and queries that the manifest names instead of files, as they are now.

    Raises
    ------
    InputError
        A database cannot be reached.
    """
    manifest = campaign.manifest
    if all(source.in_files for source in manifest.sources.values()):
        return ()
    import hashlib

    from stiffcal.reduction.logs.log_rows import fingerprint_of
    from stiffcal.store import SourceFile

    files: dict[str, SourceFile] = {}
    for name, source in manifest.sources.items():
        if source.in_files:
            continue
        named = [*manifest.files_of(name).values(), *(run.files[name] for run in manifest.runs if name in run.files)]
        for text in dict.fromkeys(named):
            rows, fingerprint = fingerprint_of(source, text)
            key = name_elsewhere(name, text)
            files[key] = SourceFile(key, rows, 0, hashlib.sha256(fingerprint.encode()).hexdigest())
    return tuple(files.values())


def ingest_settings(campaign: Campaign) -> IngestSettings:
    """Return the inputs of the load states other than files: manifest, robot, what computes."""
    return IngestSettings(
        manifest=campaign.manifest.model_dump(
            mode="json", exclude={"thresholds", "report", "trend", "plugins", "name"}
        ),
        robot=campaign.robot.model_dump(mode="json"),
        revision=REVISION,
    )
