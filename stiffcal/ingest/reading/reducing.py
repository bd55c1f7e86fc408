"""One campaign, reduced: every source read once, recordings written as they stream past, load states at the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stiffcal.campaign.found.experiment_kinds import any_measures
from stiffcal.campaign.frames.frames import frames_to_estimate, holding, measurement_setup, resolve_frames
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.campaign.robot.robot_checks import unfilled_faults
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import InputError, Progress, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.quality.data_quality import DataQuality, check_load_states, loads_of
from stiffcal.ingest.reading.logged_runs import log_files, logged_runs
from stiffcal.ingest.reading.logs_of_runs import ReadingOptions, _within, read_earlier, read_run
from stiffcal.ingest.reading.non_load_runs import NonLoadRuns
from stiffcal.ingest.reading.read_run import ReadRun
from stiffcal.ingest.reading.run_readings import RunReadings
from stiffcal.ingest.results import IngestResult
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mistakes.absolute.place_faults import place_faults, reference_fault
from stiffcal.mistakes.known_weights import weight_warnings
from stiffcal.reduction.logs.log_rows import LogRows, is_there
from stiffcal.reduction.registration.frames import Registration
from stiffcal.reduction.registration.registering import in_instrument_axes, register_frames
from stiffcal.reduction.set_aside.outliers import reject_outliers
from stiffcal.reduction.set_aside.run_displacements import check_displacements
from stiffcal.reduction.states.ingested_runs import IngestedRun, UnusedData
from stiffcal.reduction.states.load_states import load_states
from stiffcal.reduction.states.raw_states import RawStates, no_states, of_run, stacked
from stiffcal.reduction.states.rod_temperature import grown_lengths, without_growth
from stiffcal.reduction.states.tabled_states import tabled_states
from stiffcal.store import Writing


@dataclass(frozen=True)
class ReducedCampaign:
    """Everything that was made of a campaign's logs."""

    states: LoadStates
    result: IngestResult
    """How they came about, as `ingest` answers it."""
    quality: DataQuality
    """What was noticed in each file."""
    non_load: NonLoadRuns


def reduce_campaign(
    campaign: Campaign,
    progress: Progress,
    writing: Writing | None = None,
    readings: RunReadings | None = None,
) -> ReducedCampaign:
    """Read all sources of a campaign and reduce them to load states.

    Parameters
    ----------
    writing : where the recordings go as they stream past; None: nowhere.
    readings : where runs that were read earlier are found, and those that are read now are noted; None: all are read.

    Raises
    ------
    InputError
        A source is faulty, or no load states can be made of it.
    """
    ingest_options, quality, non_load = ReadingOptions(writing, readings), DataQuality(campaign), NonLoadRuns(campaign)
    gathered, runs = collect_raw_states(campaign, progress, ingest_options, quality, non_load)
    if gathered is None and non_load:
        gathered = no_states()
    if gathered is None:
        raise InputError.at(
            FaultCode.KEY_MISSING, "campaign.toml", "[[runs]]", "no run has a file",
            'add [[runs]] with files = { SOURCE = "raw/run1.csv" }, or run = { column = "run" }',
        )  # fmt: skip
    raise_faults(quality.constant_signal_faults())
    progress("reducing to load states", None)
    states, registration = placed_states(campaign, gathered)
    swept = {run.id for run in runs if run.passes}
    states = replace(states, runs=tuple(replace(run, swept=run.name in swept) for run in states.runs))
    faults, warnings = check_load_states(states, campaign, registration is not None, copied=quality.copied_runs())
    raise_faults(quality.stuck_channel_faults() + faults if faults else [])
    states = reject_outliers(states)
    grown = float(np.abs(grown_lengths(states)).max(initial=0.0))
    result = IngestResult(
        warnings=[warning for run in runs for warning in run.warnings]
        + non_load.warnings
        + quality.remarks()
        + weight_warnings(gathered)
        + warnings,
        n_states=int(states.used.sum()),
        n_set_aside=int((~states.used).sum()),
        runs=_with_non_load_runs(_ingested_runs(states, runs), non_load.entries),
        rods_grew_m=grown if grown > 0.0 else None,
        registration=None if registration is None else registration.summary,
        unchanged=False,
        changed="",
    )
    return ReducedCampaign(states, result, quality, non_load)


def _with_non_load_runs(runs: Sequence[IngestedRun], entries: Sequence[IngestedRun]) -> list[IngestedRun]:
    """Return the runs, and after them those that make no load states."""
    listed = {run.id: run for run in runs}
    for entry in entries:
        run = listed.get(entry.id)
        # a clamped run that is fitted with the others has both readings and states
        listed[entry.id] = (
            entry if run is None else replace(run, clock_ahead_s=entry.clock_ahead_s, n_readings=entry.n_readings)
        )
    return list(listed.values())


def collect_raw_states(
    campaign: Campaign,
    progress: Progress,
    ingest_options: ReadingOptions,
    quality: DataQuality,
    non_load: NonLoadRuns | None = None,
) -> tuple[RawStates | None, list[ReadRun]]:
    """Read tables and logs; None where there are no states yet. Runs without load states join `non_load`."""
    manifest, non_load = campaign.manifest, NonLoadRuns(campaign) if non_load is None else non_load
    progress("reading tables", None)
    tables: list[RawStates] = []
    try:
        table = tabled_states(campaign.folder, manifest, campaign.chain, _Tables(quality, ingest_options))
        if table is not None:
            tables.append(table if ingest_options.only is None else of_run(table, ingest_options.only))
    except InputError as error:
        ingest_options.fault(error)
    try:
        logged = logged_runs(campaign, ingest_options.readings)
        chosen = [(run, sources) for run, sources in logged if ingest_options.only in (None, run.id)]
    except InputError as error:
        ingest_options.fault(error)
        chosen = []
    runs: list[ReadRun] = []
    for k, (run, sources) in enumerate(chosen):
        within = partial(_within, progress, k / len(chosen), 1 / len(chosen))
        reduction = non_load.of_kind(run.experiment)
        try:
            read = read_earlier(run, sources, ingest_options, quality) if sources else None
            if read is None and ingest_options.collected is not None:  # files still to be measured are no faults there
                sources = _sources_there(campaign, run, sources)
            if read is None and sources:
                read = read_run(campaign, run, sources, within, ingest_options, quality, reduction is not None)
            if read is None:
                continue
            if reduction is None:
                runs.append(read)
                tables += [] if read.states is None else [read.states]
            elif reduction.reads_first_lines or not ingest_options.quick:
                states = reduction.add(run, read.blocks)
                tables += [] if states is None else [states]
        except InputError as error:
            ingest_options.fault(error)
    try:
        non_load.finish()
    except InputError as error:
        ingest_options.fault(error)
    return (stacked(tables) if tables else None), [] if ingest_options.quick else runs


def _sources_there(campaign: Campaign, run: Run, sources: Sequence[str]) -> list[str]:
    """Return those sources of a run whose files are there."""
    settings = campaign.manifest.sources
    return [name for name, file in log_files(campaign, run, sources) if is_there(campaign.folder, settings[name], file)]


@dataclass(frozen=True)
class _Tables:
    """What is noticed in tables of states while they are read, and what reading those of single runs gave earlier."""

    quality: DataQuality
    options: ReadingOptions

    def update(self, source: str, file: str, rows: LogRows) -> None:
        self.quality.update(source, file, rows)

    def earlier(self, source: str, run: Run) -> RawStates | None:
        read = None if self.options.readings is None else self.options.readings.find_table(run, source)
        if read is None or read.states is None:
            return None
        for log in read.logs:
            self.quality.add(log, "")
            self.quality.compare_rows(source, log.summary.file, read.states)
        return read.states

    def finish(self, source: str, file: str, run: Run | None, states: RawStates) -> None:
        if not self.quality.has_begun(source, file):  # all of its rows are excluded
            return
        log = self.quality.finish(source, file)
        self.quality.compare_rows(source, file, states)
        if run is not None and self.options.readings is not None:
            self.options.readings.note_table(run, source, ReadRun(run.id, (log,), states))


def placed_states(campaign: Campaign, gathered: RawStates) -> tuple[LoadStates, Registration | None]:
    """Return load states in base axes; frames to be estimated are found first, from the references."""
    manifest, chain = campaign.manifest, campaign.chain
    with_states = set(gathered.run)
    kinds = (run.experiment for run in manifest.runs if run.id in with_states)
    any_held = any_measures(kinds, StateMeasure.MOTOR_ANGLE)
    setup = measurement_setup(manifest, chain, resolve_frames(manifest, chain))
    states = load_states(gathered, manifest, chain, holding(setup) if any_held else setup)
    if not states.clamped.all():
        raise_faults(unfilled_faults(campaign.robot, manifest.robot))
    if states.absolute.any():
        # before the frames are found, which wrong rows would draw away
        raise_faults(place_faults(states, campaign))
    raise_faults(check_displacements(states.select(loads_of(states)[states.run] & states.used), MANIFEST_FILE))
    names = frames_to_estimate(manifest)
    if not names:
        return without_growth(states), None
    try:
        registration = register_frames(in_instrument_axes(states), manifest, chain, names)
    except InputError as error:
        contradict = error.code is FaultCode.KINEMATICS_MISMATCH
        fault = reference_fault(states, campaign) if contradict and not states.absolute.any() else None
        if fault is None:
            raise
        raise InputError(fault) from None
    setup = measurement_setup(manifest, chain, resolve_frames(manifest, chain, registration.frames))
    return without_growth(load_states(gathered, manifest, chain, holding(setup) if any_held else setup)), registration


def _ingested_runs(states: LoadStates, runs: Sequence[ReadRun]) -> list[IngestedRun]:
    """Return of each run with load states its clocks, number of states, what is not used, passes of swept loads."""
    by_name = {run.id: run for run in runs}
    ingested = []
    used = states.used
    for name, members in states.members_by_name().items():
        reduced = by_name.get(name)
        set_aside = [
            UnusedData(state=int(states.row[k]), why=str(states.set_aside[k]), code=str(states.set_aside_code[k]))
            for k in members[~used[members]]
        ]
        ingested.append(
            IngestedRun(
                id=name,
                clock_ahead_s={} if reduced is None else dict(reduced.clocks),
                n_states=int(used[members].sum()),
                dropped=([] if reduced is None else list(reduced.dropped)) + set_aside,
                passes=None if reduced is None else reduced.passes or None,
            )
        )
    return ingested
