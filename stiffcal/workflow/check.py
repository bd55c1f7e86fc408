"""What was understood of a campaign, every fault with its place, and what is still missing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from stiffcal.errors import Fault, InputError, Progress, no_progress, raise_faults
from stiffcal.ingest.proposals import propose_sources
from stiffcal.planning.rod_views import rod_views

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.ingest.data_quality import DataQuality
    from stiffcal.ingest.reducing import NonLoadRuns
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.reduction.plausibility import LogQuality

SCHEMA = "stiffcal/check/1"


def check_campaign(
    folder: str | Path, quick: bool = False, run: str | None = None, progress: Progress = no_progress
) -> dict[str, Any]:
    """Read everything and say what was understood.

    Parameters
    ----------
    folder : the campaign folder; files of runs that are still to be measured may be missing.
    quick : only the first lines of each log.
    run : only this run.

    Returns
    -------
    The check document: ``sources`` (per file: rows, rate, span, gap, ranges, what moved), ``runs``, ``kinematics``,
    ``joints`` (torque that each saw, and how well its stiffness could be known), ``ready``, ``missing``.

    Raises
    ------
    InputError
        With every fault of every file, each with file, line and column.
    """
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.ingest.data_quality import DataQuality, check_load_states
    from stiffcal.ingest.reducing import NonLoadRuns, ReadingOptions, collect_raw_states, placed_states
    from stiffcal.reduction.outliers import reject_outliers

    campaign = load_campaign(Path(folder), check_files=False)
    _check_run(campaign, run)
    faults: list[Fault] = []
    quality = DataQuality(campaign)
    non_load = NonLoadRuns()
    gathered, reduced = collect_raw_states(
        campaign, progress, ReadingOptions(collected=faults, only=run, quick=quick), quality, non_load
    )
    missing = _missing_files(campaign, run)
    faults = [fault for fault in faults if not _is_missing(fault)]
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "warnings": [],
        "campaign": campaign.name,
        "sources": _sources(campaign, quality),
    }
    if gathered is not None and not faults:
        progress("looking at load states", None)
        states, registration = placed_states(campaign, gathered)
        found, warnings = check_load_states(states, campaign, registration is not None)
        faults += quality.causes() + found if found else []
        if not faults:
            states = states if quick else reject_outliers(states)
            document |= _states(campaign, states, reduced)
            document["warnings"] = quality.remarks() + warnings + [w for part in reduced for w in part.warnings]
            if states.setup.rods:
                document["rods"] = rod_views(campaign, states.setup)
            if registration is not None:
                document["registration"] = registration.as_document()
            if not quick or any(source.is_states for source in campaign.manifest.sources.values()):
                missing += _joints(campaign, states, document)
    elif gathered is None and not faults and not non_load and not (quick and _read_in_full(campaign)):
        missing.append("no load states yet: measure a run")
    if non_load and not faults:
        missing += _beside(campaign, non_load, document)
    raise_faults(faults)
    if proposals := propose_sources(campaign):
        document["proposals"] = proposals
    document["ready"] = not missing
    document["missing"] = missing
    return document


def _read_in_full(campaign: Campaign) -> bool:
    """Tell whether the campaign holds runs of which the first lines alone say nothing."""
    return any(run.experiment in ("clamped", "friction") for run in campaign.manifest.runs)


def _beside(campaign: Campaign, non_load: NonLoadRuns, document: dict[str, Any]) -> list[str]:
    """Add runs that make no load states to the document; return what is missing of them."""
    experiments = {run.id: run.experiment for run in campaign.manifest.runs}
    document.setdefault("runs", [])
    document.setdefault("kinematics", None)
    document.setdefault("n_states", 0)
    listed = {run["id"]: run for run in document["runs"]}
    for entry in non_load.entries:
        if entry["id"] in listed:  # fitted with the load runs: it has states too
            listed[entry["id"]]["n_readings"] = entry.get("n_readings", 0)
            continue
        document["runs"].append(
            {
                "id": entry["id"],
                "experiment": experiments.get(entry["id"], ""),
                "n_states": 0,
                "n_readings": entry.get("n_readings", 0),
                "set_aside": [str(one["why"]) for one in entry["dropped"]],
                "largest_force_N": None,
                "work_J": None,
                "clock_ahead_s": entry["clock_ahead_s"],
            }
        )
    document["warnings"] += non_load.warnings
    unusable: list[str] = []
    if non_load.clamped:
        from stiffcal.workflow.clamped import contradictions_of

        unusable, remarks = contradictions_of(campaign, non_load.clamped)
        document["warnings"] += remarks
    return unusable + _without_friction(campaign, non_load)


def _without_friction(campaign: Campaign, non_load: NonLoadRuns) -> list[str]:
    """Return a line for every joint whose friction the model asks for and no run tells."""
    from stiffcal.workflow.steps import moving_effects

    if non_load.friction is None:
        return []
    steady, motion = non_load.friction.steady, non_load.friction.motion
    told = set() if steady is None else set(steady.joint[steady.used].tolist())
    if motion is not None:
        told |= {k + 1 for k, moved in enumerate(motion.one_way.T) if moved.any()}
    names = campaign.chain.joint_names
    asked = [one.place.joints[0] for one in moving_effects(campaign)]
    return [f"joint {names[k - 1]}: no run tells its friction: move it both ways" for k in asked if k not in told]


def _check_run(campaign: Campaign, run: str | None) -> None:
    names = [entry.id for entry in campaign.manifest.runs]
    if run is not None and names and run not in names:
        raise InputError.at("campaign.toml", "[[runs]]", f"there is no run {run!r}", f"runs: {', '.join(names[:20])}")


def _is_missing(fault: Fault) -> bool:
    return fault.reason == "no such file"


def _missing_files(campaign: Campaign, only: str | None) -> list[str]:
    """Return one line for every file that is named and not there yet."""
    told, sources = [], campaign.manifest.sources
    homeless: dict[str, int] = {}  # a folder that is not there is told once, not for each of its files

    def absent(files: Iterable[str]) -> list[str]:
        missing = [file for file in files if not (campaign.folder / file).exists()]
        for file in missing:
            parent = PurePosixPath(file).parent
            if not (campaign.folder / parent).is_dir():
                homeless[str(parent)] = homeless.get(str(parent), 0) + 1
        return [file for file in missing if str(PurePosixPath(file).parent) not in homeless]

    for entry in campaign.manifest.runs:
        if only in (None, entry.id):
            files = absent(entry.files[name] for name in entry.files if sources[name].in_files)
            told += [f"run {entry.id}: {', '.join(files)} not there yet"] if files else []
    for name in sources:
        if not sources[name].in_files:
            continue
        told += [f"source {name}: {file} not there yet" for file in absent(campaign.manifest.files_of(name).values())]
    return [f"folder {name}: not there yet, {count} files are named in it" for name, count in homeless.items()] + told


def _sources(campaign: Campaign, quality: DataQuality) -> list[dict[str, Any]]:
    """Return what was seen of each file."""
    return [
        _file(campaign, source, watch)
        for (source, _, _), watch in quality.logs.items()
    ]  # fmt: skip


def _file(campaign: Campaign, name: str, watch: LogQuality) -> dict[str, Any]:
    source = campaign.manifest.sources[name]
    units = {
        column: unit.name
        for signal in source.signals().values()
        for column, unit in signal.columns_with_units().items()
    }
    told: dict[str, Any] = {"source": name, "file": watch.file, "rows": watch.n_rows}
    if watch.sampled:
        told["rate_hz"] = _number(1.0 / watch.interval if watch.interval > 0.0 else None)
        told["span_s"] = _number(watch.last_s - watch.first_s)
        told["longest_gap_s"] = _number(watch.longest)
    signals = []
    for signal, low in watch.low.items():
        high, columns = watch.high[signal], watch.columns.get(signal, ())
        if signal == "wrench" and source.wrench is not None and source.wrench.direction is not None:
            low, high = _along(source.wrench.direction, low, high)
        for k, column in enumerate(columns[: low.size]):
            signals.append(
                {
                    "signal": signal,
                    "column": column,
                    "unit": units.get(column, ""),
                    "low_si": _number(low[k]),
                    "high_si": _number(high[k]),
                    "moved": bool(high[k] > low[k]),
                }
            )
    told["columns"] = signals
    return told


def _along(direction: Sequence[float], low: Any, high: Any) -> tuple[Any, Any]:
    """Return the ends of a force along a line, told by the component that it makes most of."""
    import numpy as np

    unit = np.array(direction) / np.linalg.norm(direction)
    most = int(np.argmax(np.abs(unit)))
    ends = sorted((low[most] / unit[most], high[most] / unit[most]))
    return np.array(ends[:1]), np.array(ends[1:])


def _number(value: Any) -> float | None:
    """Return a finite float, or None."""
    import math

    return float(value) if value is not None and math.isfinite(value) else None


def _states(campaign: Campaign, states: LoadStates, reduced: list[Any]) -> dict[str, Any]:
    """Return what was made of the runs, and whether kinematics meets the tracker."""
    import numpy as np

    from stiffcal.reduction.consistency import match_kinematics, work_of_load

    clocks = {part.states.run[0]: part.clocks for part in reduced}
    runs = []
    aside = [f"state {row}: {why}" if why else "" for row, why in zip(states.row, states.set_aside, strict=True)]
    loads = states.setup.targets and bool(np.any(states.wrench))
    work = work_of_load(states, campaign.chain).work if loads else np.full(len(states.runs), np.nan)
    for k, (info, own) in enumerate(zip(states.runs, states.members(), strict=True)):
        runs.append(
            {
                "id": info.name,
                "experiment": info.experiment,
                "n_states": int(states.used[own].sum()),
                "set_aside": [aside[i] for i in own if aside[i]],
                "largest_force_N": _number(np.linalg.norm(states.wrench[own, :3], axis=1).max(initial=0.0)),
                "work_J": _number(work[k]),
                "clock_ahead_s": {
                    name: offset.as_document() for name, offset in clocks.get(info.name, {}).items()
                },
            }
        )  # fmt: skip
    match = match_kinematics(states, campaign.chain)
    kinematics = {
        "median_m": _number(match.median_m),
        "worst_m": _number(match.worst_m),
        "orientation_rad": _number(match.turned_rad),
    }
    return {"runs": runs, "kinematics": kinematics, "n_states": int(states.used.sum())}


def _joints(campaign: Campaign, states: LoadStates, document: dict[str, Any]) -> list[str]:
    """Add what each joint saw to the document; return what is missing to identify it."""
    from stiffcal.reduction.excitation import joint_excitation

    entries = joint_excitation(states, campaign.chain)
    document["joints"] = [
        {
            "joint": entry.name,
            "largest_torque_Nm": _number(entry.torque),
            "expected_relative_std": _number(entry.relative_std),
            "says": entry.verdict,
        }
        for entry in entries
    ]
    return [f"joint {entry.name}: {entry.verdict}" for entry in entries if not entry.identifiable]
