"""Logs of one run, read once: as block averages, or as the load states that they hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.gauges import metres_of_rods
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.campaign.manifest.source import Source
from stiffcal.errors import Fault, InputError, Progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.quality.data_quality import DataQuality, ReadLog
from stiffcal.ingest.reading.logged_runs import log_files
from stiffcal.ingest.reading.logged_runs import of_run as rows_of_run
from stiffcal.ingest.reading.read_run import ReadRun
from stiffcal.ingest.reading.recording_tables import recording_columns, recording_name, recording_table
from stiffcal.ingest.reading.run_readings import RunReadings
from stiffcal.mistakes.clocks.found import clock_warnings
from stiffcal.readers import WantedColumns
from stiffcal.reduction.holds.finding import Holds, given_holds
from stiffcal.reduction.logs.blocks import BlockAverager, Blocks
from stiffcal.reduction.logs.excluded_rows import ExcludedStretches, RowExclusions
from stiffcal.reduction.logs.log_rows import read_batches, read_rows
from stiffcal.reduction.logs.motor_side import MotorSide
from stiffcal.reduction.states.ingested_runs import sum_up_dropped
from stiffcal.reduction.states.recordings import beginning, reduce_run
from stiffcal.store import TableStream, Writing

PIECE_BYTES = 1 << 22  # what a reader of text takes at a time


@dataclass(frozen=True)
class ReadingOptions:
    """How a campaign is read."""

    writing: Writing | None = None
    """Where the recordings go as they stream past; None: nowhere."""
    readings: RunReadings | None = None
    """Where runs that were read earlier are found, and those that are read now are noted; None: all are read."""
    collected: list[Fault] | None = None
    """Faults of files join this list instead of stopping (`check`); None: the first one stops."""
    only: str | None = None
    """This run alone."""
    quick: bool = False
    """Only the first lines of logs."""

    def fault(self, error: InputError) -> None:
        """Collect a fault, or raise it."""
        if self.collected is None:
            raise error
        # a library is installed once, however many logs it reads
        missing = {replace(fault, file="") for fault in self.collected if fault.code is FaultCode.LIBRARY_MISSING}
        self.collected.extend(fault for fault in error.faults if replace(fault, file="") not in missing)


def read_earlier(
    run: Run, sources: Sequence[str], ingest_options: ReadingOptions, quality: DataQuality
) -> ReadRun | None:
    """Return what reading a run gave earlier, None where it has to be read."""
    if ingest_options.readings is None or ingest_options.quick:
        return None
    read = ingest_options.readings.find(run, sources, ingest_options.writing)
    for log in () if read is None else read.logs:
        quality.add(log, run.id)
    return read


def read_run(
    campaign: Campaign,
    run: Run,
    sources: Sequence[str],
    progress: Progress,
    ingest_options: ReadingOptions,
    quality: DataQuality,
    as_blocks: bool,
) -> ReadRun | None:
    """Read the logs of a run, None where one is faulty and faults are collected.

    Whatever setting counts here enters the run's key too (`run_keys`): else what is stored outlives a change of it.

    Parameters
    ----------
    as_blocks : its kind of experiment takes the logs as block averages; else they are reduced to load states.

    Raises
    ------
    InputError : no load state can be made of the logs.
    """
    logs = _read_logs(campaign, run, sources, progress, ingest_options, quality)
    blocks = {source: of_log for source, (_, of_log) in logs.items()}
    if ingest_options.quick and not as_blocks:
        return ReadRun(run.id, (), beginning(run, blocks)) if logs else None
    if len(logs) < len(sources):
        return None
    read = ReadRun(run.id, tuple(log for log, _ in logs.values()), blocks=blocks)
    if not as_blocks:
        reduced = reduce_run(run, blocks, _tabled_holds(campaign, run, sources[0]))
        read = replace(
            read,
            states=reduced.states,
            clocks=reduced.clocks,
            dropped=tuple(sum_up_dropped(reduced.dropped)),
            warnings=(*clock_warnings(run.id, reduced.courses), *reduced.warnings),
            passes=reduced.passes,
            blocks={},
        )
    if ingest_options.readings is not None and not ingest_options.quick:
        ingest_options.readings.note(run, sources, read)
    return read


def _within(progress: Progress, start: float, width: float, text: str, fraction: float | None = None) -> None:
    progress(text, None if fraction is None else start + width * fraction)


def _read_logs(
    campaign: Campaign,
    run: Run,
    sources: Sequence[str],
    progress: Progress,
    ingest_options: ReadingOptions,
    quality: DataQuality,
) -> dict[str, tuple[ReadLog, Blocks]]:
    """Read the logs of a run; faulty ones are left out where faults are collected."""
    logs: dict[str, tuple[ReadLog, Blocks]] = {}
    for k, name in enumerate(sources):
        report_progress = partial(_within, progress, k / len(sources), 1 / len(sources))
        try:
            logs[name] = _read_log(campaign, run, name, report_progress, ingest_options, quality)
        except InputError as error:
            ingest_options.fault(error)
    return logs


def _read_log(
    campaign: Campaign, run: Run, name: str, progress: Progress, ingest_options: ReadingOptions, quality: DataQuality
) -> tuple[ReadLog, Blocks]:
    """Stream one log: into the store as it is, into block averages for everything else."""
    source = campaign.manifest.sources[name]
    ((_, file),) = log_files(campaign, run, [name])
    averager, stretches = BlockAverager(), ExcludedStretches()
    stream: TableStream | None = None
    exclusions = RowExclusions.of(campaign.manifest, name, run.id)
    path = campaign.folder / file
    size, rows_reported = path.stat().st_size if path.exists() else 0, 0.0  # a database's table is no file
    progress(f"reading {file}", 0.0)
    motors = MotorSide(source, campaign.chain, name)
    files = campaign.manifest.files_of(name, run)
    metres = metres_of_rods(campaign.manifest)
    for everything in read_rows(campaign.folder, name, source, files, exclusions=exclusions, metres_of_rods=metres):
        rows = motors.joint_side(rows_of_run(source, run, everything))
        if len(rows) == 0:
            continue
        excluded = exclusions.mask(rows.number, rows.run)
        rows_in_use = rows.chosen(~excluded) if excluded.any() else rows
        quality.update(name, file, rows_in_use, run.id)
        if ingest_options.writing is not None:
            if stream is None:
                stream = ingest_options.writing.stream(recording_name(run.id, name), recording_columns(source, rows))
            stream.append(recording_table(source, rows))
        averager.add(rows_in_use.time, rows_in_use.signals)
        stretches.update(rows.time, excluded)
        # a guess from the first piece is good enough for a bar
        rows_reported = rows_reported or max(len(rows) * size / PIECE_BYTES, float(len(rows)))
        progress(f"reading {file}", min(float(rows.number[-1]) / rows_reported, 1.0) if len(rows) else None)
        if ingest_options.quick:
            break
    if stream is not None:
        stream.close()
    try:
        blocks = replace(averager.blocks(), excluded=stretches.array())
    except ValueError:
        raise InputError.at(
            FaultCode.FILE_EMPTY, file, "", "no reading of this log remains", "check rows = … and exclude"
        ) from None
    return quality.finish(name, file, run.id), blocks


def _tabled_holds(campaign: Campaign, run: Run, first: str) -> Holds | None:
    """Read the holds that the run's table states, s of the first source's clock."""
    if run.states is None:
        return None
    source = campaign.manifest.sources[first]
    columns = WantedColumns(("start", "end"))
    start: list[Floats] = []
    end: list[Floats] = []
    plain = Source()
    for batch in read_batches(campaign.folder, plain, run.states, columns):
        start.append(batch.numbers["start"])
        end.append(batch.numbers["end"])
    holds = given_holds(np.concatenate(start), np.concatenate(end))
    bad = np.flatnonzero(holds.end <= holds.start)
    if bad.size:
        k = int(bad[0])
        raise InputError.at(
            FaultCode.TIME_ORDER, run.states, f"data row {k + 1}",
            f"the dwell ends ({holds.end[k]:g} s) before it starts ({holds.start[k]:g} s)",
            f"give start and end in seconds of the clock of {first} ({source.format or 'its log'})",
        )  # fmt: skip
    return holds
