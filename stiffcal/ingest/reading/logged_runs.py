"""Which runs the logs hold: each with its own files, or one log for all, distinguished by its run column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.campaign.manifest.source import Source
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reading.run_readings import RunReadings
from stiffcal.readers import WantedColumns
from stiffcal.reduction.logs.log_rows import LogRows, is_there, read_batches


def logged_runs(campaign: Campaign, readings: RunReadings | None = None) -> list[tuple[Run, list[str]]]:
    """Return every run with the sources that log it, in the manifest's order.

    A log for all runs is read through once for the names in its run column.

    Parameters
    ----------
    readings : may know these names, and takes them; None: they are read.

    Raises
    ------
    InputError
        A log holds a run that the manifest does not list; its run column cannot be read.
    """
    manifest = campaign.manifest
    logged = [name for name, source in manifest.sources.items() if not source.is_states]
    names_of_source = {
        name: _names_in(campaign, name, readings) for name in logged if _has_column(manifest.sources[name])
    }
    runs = manifest.runs or tuple(
        Run(id=name) for name in dict.fromkeys(n for names in names_of_source.values() for n in names)
    )
    listed = {run.id for run in runs}
    for source, names in names_of_source.items():
        unknown = [name for name in names if name not in listed]
        if unknown:
            raise InputError.at(
                FaultCode.RUN_UNKNOWN,
                "campaign.toml", "[[runs]]", f"the log of {source} contains run {unknown[0]!r}, which is not listed",
                "add it to [[runs]], or omit [[runs]] if there is a run column",
            )  # fmt: skip
    return [
        (
            run,
            [
                name
                for name in logged
                if name in run.files
                or (
                    run.id in names_of_source[name]
                    if name in names_of_source
                    else bool(manifest.files_of(name)) and len(runs) == 1
                )
            ],
        )
        for run in runs
    ]


def of_run(source: Source, run: Run, rows: LogRows) -> LogRows:
    """Return the rows that belong to a run: all, unless the source names runs in a column."""
    if not _has_column(source):
        return rows
    keep = np.array([name == run.id for name in rows.run], dtype=np.bool_)
    if keep.all():
        return rows
    return replace(
        rows,
        number=rows.number[keep],
        time=rows.time[keep],
        run=[run.id] * int(keep.sum()),
        signals={name: values[:, keep] for name, values in rows.signals.items()},
    )


def log_files(campaign: Campaign, run: Run, sources: Sequence[str]) -> list[tuple[str, str]]:
    """Return (source, file) for each source of a run; of a source in several files the first stands for it."""
    return [(name, next(iter(campaign.manifest.files_of(name, run).values()))) for name in sources]


def _has_column(source: Source) -> bool:
    return source.run is not None and source.run.column is not None and bool(source.own_file or source.files)


def _names_in(campaign: Campaign, name: str, readings: RunReadings | None) -> Sequence[str]:
    """Return the names in a log's run column, in order; none where the log is not there yet."""
    source = campaign.manifest.sources[name]
    column = source.run.column if source.run is not None and source.run.column is not None else ""
    file = source.own_file or source.files.get("run")
    if file is None:
        raise InputError.at(
            FaultCode.KEY_MISSING,
            "campaign.toml", f"[sources.{name}.files]", f'no file is given for the run column "{column}"',
            'add run = "raw/….csv", the file that contains it',
        )  # fmt: skip
    if not is_there(campaign.folder, source, file):
        return []
    known = None if readings is None else readings.find_names(name, file)
    if known is None:
        names: dict[str, None] = {}
        for batch in read_batches(campaign.folder, source, file, WantedColumns((), (column,))):
            names |= dict.fromkeys(batch.texts[column])
        known = list(names)
    if readings is not None:
        readings.note_names(name, file, known)
    return known
