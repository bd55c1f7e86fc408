"""What was understood of a campaign, every fault with its place, and what is still missing."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.campaign.checks.unused_settings import unused_settings
from stiffcal.campaign.manifest.found_runs import unpartnered_remarks
from stiffcal.errors import Fault, InputError, Progress, no_progress, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.absolute import joints_from_places, poses_still_needed, poses_without_frames
from stiffcal.ingest.checks.results import (
    CheckedJoint,
    CheckedKinematics,
    CheckedRun,
    CheckResult,
)
from stiffcal.ingest.checks.run_files import files_of, finite_number, is_missing, missing_files
from stiffcal.ingest.proposals import propose_sources
from stiffcal.planning.rod_views import rod_views

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.ingest.reading.non_load_runs import NonLoadRuns
    from stiffcal.ingest.reading.read_run import ReadRun
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.store import Store


def check_campaign(
    folder: str | Path, quick: bool = False, run: str | None = None, progress: Progress = no_progress
) -> CheckResult:
    """Read everything and say what was understood.

    Parameters
    ----------
    folder : the campaign folder; files of runs that are still to be measured may be missing.
    quick : only the first lines of each log.
    run : only this run.

    Returns
    -------
    CheckResult
        What was understood of each file and run, and what is still missing.

    Raises
    ------
    InputError
        With every fault of every file, each with file, line and column.
    """
    from stiffcal.campaign.loading import load_campaign

    campaign = load_campaign(Path(folder), check_files=False)
    _check_run(campaign, run)
    return check_loaded(campaign, quick, run, progress)


def check_loaded(
    campaign: Campaign,
    quick: bool = False,
    run: str | None = None,
    progress: Progress = no_progress,
    store: Store | None = None,
) -> CheckResult:
    """Do as `check_campaign` with a campaign that was read, all its runs or some of them.

    Parameters
    ----------
    campaign, quick, run, progress : as there.
    store : where runs that were read are not read again; None: the campaign's own.

    Raises
    ------
    InputError : as `check_campaign`.
    """
    from stiffcal.ingest.quality.data_quality import DataQuality, check_load_states
    from stiffcal.ingest.reading.logs_of_runs import ReadingOptions
    from stiffcal.ingest.reading.non_load_runs import NonLoadRuns
    from stiffcal.ingest.reading.reducing import collect_raw_states, placed_states
    from stiffcal.ingest.reading.run_readings import earlier_readings
    from stiffcal.judgement.suspects import suspects_in
    from stiffcal.kinds.declared_tables import campaign_store
    from stiffcal.mistakes.known_weights import weight_warnings
    from stiffcal.reduction.set_aside.outliers import reject_outliers

    any_table = any(source.is_states for source in campaign.manifest.sources.values())
    faults: list[Fault] = []
    quality = DataQuality(campaign)
    non_load = NonLoadRuns(campaign)
    place = store or campaign_store(campaign.folder / "store", display_name="store")
    with nullcontext() if quick else earlier_readings(campaign, place, run) as readings:
        options = ReadingOptions(readings=readings, collected=faults, only=run, quick=quick)
        gathered, reduced = collect_raw_states(campaign, progress, options, quality, non_load)
    missing = missing_files(campaign, run, {file for _, file, _ in quality.logs})
    faults = [fault for fault in faults if not is_missing(fault)]
    if not quick and not faults:  # of the first lines of a log nothing need have changed
        faults = quality.constant_signal_faults()
    result = CheckResult(
        warnings=[],
        campaign=campaign.name,
        sources=files_of(campaign, quality),
        runs=[],
        kinematics=None,
        n_states=0,
        ready=False,
        missing=[],
    )
    if gathered is not None and not faults:
        progress("checking load states", None)
        try:
            states, registration = placed_states(campaign, gathered)
        except InputError as error:
            needed = poses_still_needed(campaign, gathered, error)
            if needed is None:
                raise
            measured = poses_without_frames(campaign, gathered)
            return replace(
                result,
                warnings=unpartnered_remarks(campaign.manifest, campaign.found) + quality.remarks() + _unused(campaign),
                runs=[replace(entry, work_J=None) for entry in _load_runs(campaign, measured, reduced)],
                n_states=int(measured.used.sum()),
                missing=missing + needed,
                proposals=propose_sources(campaign) or None,
            )
        more_to_come = bool(missing) or (quick and not any_table)
        load_faults, warnings = check_load_states(
            states, campaign, registration is not None, more_to_come, quality.copied_runs()
        )
        faults += quality.stuck_channel_faults() + load_faults if load_faults else []
        if not faults:
            states = states if quick else reject_outliers(states)
            result = replace(
                result,
                warnings=quality.remarks()
                + weight_warnings(gathered)
                + warnings
                + [warning for reduction in reduced for warning in reduction.warnings],
                runs=_load_runs(campaign, states, reduced),
                kinematics=_kinematics(campaign, states),
                n_states=int(states.used.sum()),
                rods=rod_views(campaign, states.setup) if states.setup.rods else None,
                registration=None if registration is None else registration.summary,
            )
            if not quick or any_table:
                if states.absolute.any():
                    places = joints_from_places(campaign, states)
                    joints, unidentifiable = places.joints, places.missing
                    result = replace(
                        result,
                        observability=places.observability,
                        noise=places.noise,
                        warnings=[*result.warnings, *places.remarks],
                    )
                else:
                    joints, unidentifiable = _joints(campaign, states)
                result, missing = replace(result, joints=joints), missing + unidentifiable
            if not quick:
                suspects, not_checked = suspects_in(campaign, states, progress=progress)
                result = replace(result, suspects=suspects, suspects_not_checked=not_checked)
    elif gathered is None and not faults and not non_load and not (quick and _read_in_full(campaign)):
        missing.append("no load states yet: measure a run")
    if non_load and not faults:
        unusable, remarks = non_load.check()
        of_logs = quality.remarks() if gathered is None else []  # else they are among the warnings
        result = replace(
            result,
            warnings=[*result.warnings, *of_logs, *remarks],
            runs=_with_non_load_runs(campaign, result.runs, non_load),
        )
        missing += unusable
    raise_faults(faults)
    remarks = unpartnered_remarks(campaign.manifest, campaign.found) + _new_runs(campaign)
    return replace(
        result,
        warnings=[*remarks, *result.warnings, *_unused(campaign)],
        proposals=propose_sources(campaign) or None,
        ready=not missing,
        missing=missing,
        states_report="report" in campaign.manifest.model_fields_set,
    )


def _unused(campaign: Campaign) -> list[str]:
    """Return a sentence for each setting of the manifest that nothing reads."""
    return unused_settings(campaign.manifest, _frames_of_simulation(campaign))


def _frames_of_simulation(campaign: Campaign) -> list[str]:
    """Return the frames that simulate.toml may name; all where it cannot be read, which `simulate` reports."""
    if not (campaign.folder / "simulate.toml").exists():
        return []
    from stiffcal.simulation.settings import Loads, load_settings

    try:
        settings = load_settings(campaign.folder)
    except InputError:
        return list(campaign.manifest.frames)
    words = str(settings.model_dump())
    return [name for name in campaign.manifest.frames if repr(name) in words or name == Loads().point]


def _new_runs(campaign: Campaign) -> list[str]:
    """Return a sentence on the runs that files have added since the last ingest."""
    if campaign.found is None:
        return []
    from stiffcal.ingest.freshness import new_runs
    from stiffcal.kinds.declared_tables import campaign_store
    from stiffcal.wording import count, listing

    names = new_runs(campaign, campaign_store(campaign.folder / "store", display_name="store"))
    return [f"{count(len(names), 'run')} new since the last ingest: {listing(names)}"] if names else []


def _read_in_full(campaign: Campaign) -> bool:
    """Return whether the campaign holds runs of which the first lines alone are not enough."""
    from stiffcal.ingest.reading.non_load_runs import NonLoadRuns

    non_load = NonLoadRuns(campaign)
    return any(non_load.of_kind(run.experiment) is not None for run in campaign.manifest.runs)


def _with_non_load_runs(campaign: Campaign, runs: Sequence[CheckedRun], non_load: NonLoadRuns) -> list[CheckedRun]:
    """Return the runs, and after them those that make no load states."""
    experiments = {run.id: run.experiment for run in campaign.manifest.runs}
    listed = {run.id: run for run in runs}
    for entry in non_load.entries:
        name, n_readings = entry.id, entry.n_readings or 0
        if name in listed:  # fitted with the load runs: it has states too
            listed[name] = replace(listed[name], n_readings=n_readings)
            continue
        listed[name] = CheckedRun(
            id=name,
            experiment=experiments.get(name, ""),
            n_states=0,
            n_readings=n_readings,
            set_aside=[unused.why for unused in entry.dropped],
            largest_force_N=None,
            clock_ahead_s=entry.clock_ahead_s,
        )
    return list(listed.values())


def _check_run(campaign: Campaign, run: str | None) -> None:
    names = [entry.id for entry in campaign.manifest.runs]
    if run is not None and names and run not in names:
        raise InputError.at(
            FaultCode.RUN_UNKNOWN,
            "campaign.toml",
            "[[runs]]",
            f"there is no run {run!r}",
            f"runs: {', '.join(names[:20])}",
        )


def _load_runs(campaign: Campaign, states: LoadStates, reduced: Sequence[ReadRun]) -> list[CheckedRun]:
    """Return the summaries of the runs that give load states."""
    import numpy as np

    from stiffcal.mistakes.displacements.springs import work_of_runs

    clocks = {run.id: run.clocks for run in reduced}
    set_aside = [f"state {row}: {why}" if why else "" for row, why in zip(states.row, states.set_aside, strict=True)]
    loads = states.setup.targets and bool(np.any(states.wrench))
    work = work_of_runs(states, campaign.chain) if loads else np.full(len(states.runs), np.nan)
    force = np.linalg.norm(states.wrench[:, :3], axis=1)
    return [
        CheckedRun(
            id=name,
            experiment=states.runs[int(states.run[own[0]])].experiment if own.size else "",
            n_states=int(states.used[own].sum()),
            set_aside=[set_aside[i] for i in own if set_aside[i]],
            largest_force_N=finite_number(force[own].max(initial=0.0)),
            work_J=finite_number(np.sum(work[sorted(set(states.run[own].tolist()))])),
            clock_ahead_s=dict(clocks.get(name, {})),
        )
        for name, own in states.members_by_name().items()
    ]


def _kinematics(campaign: Campaign, states: LoadStates) -> CheckedKinematics:
    """Return whether kinematics meets the tracker."""
    from stiffcal.mistakes.references.match import match_kinematics

    match = match_kinematics(states, campaign.chain)
    return CheckedKinematics(
        median_m=finite_number(match.median_m),
        worst_m=finite_number(match.worst_m),
        orientation_rad=finite_number(match.turned_rad),
    )


def _joints(campaign: Campaign, states: LoadStates) -> tuple[list[CheckedJoint], list[str]]:
    """Return the torques of the loads on each joint, and what is missing to identify it."""
    from stiffcal.campaign.signals.signals import DeadWeight, Wrench
    from stiffcal.reduction.loads.excitation import joint_excitation

    if states.clamped.all():
        # what their kind states of each run replaces it: nothing but the driven joint is measured
        return [], []
    entries = joint_excitation(states, campaign.chain)
    joints = [
        CheckedJoint(
            joint=entry.name,
            largest_torque_Nm=finite_number(entry.torque),
            expected_relative_std=finite_number(entry.relative_std),
            says=entry.verdict,
            prismatic=True if entry.name in campaign.chain.prismatic_names else None,
        )
        for entry in entries
    ]
    if not any(isinstance(signal, Wrench | DeadWeight) for _, _, signal in campaign.manifest.signals()):
        return joints, [
            "no source of campaign.toml reads a load: add wrench to the one that logs forces, or mass to a table"
        ]
    return joints, [f"joint {entry.name}: {entry.verdict}" for entry in entries if not entry.identifiable]
