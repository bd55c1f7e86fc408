"""One campaign, reduced: every source read once, recordings written as they stream past, load states at the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.frames import frames_to_estimate, measurement_setup, resolve_frames
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest import Run, Source
from stiffcal.errors import InputError, Progress, raise_faults
from stiffcal.measurements.load_states import LoadStates
from stiffcal.readers import Wanted
from stiffcal.reduction.blocks import BlockAverager, Blocks
from stiffcal.reduction.holds import Holds, given_holds
from stiffcal.reduction.logs import Rows, read_batches, read_rows
from stiffcal.reduction.recordings import ReducedRun, reduce_run
from stiffcal.reduction.registration import Registration, in_instrument_axes, register_frames
from stiffcal.reduction.screening import set_bumped_aside
from stiffcal.reduction.states import Gathered, load_states, stacked, tabled_states
from stiffcal.store import TableStream, Writing
from stiffcal.workflow.watching import Watches, contradictions

Floats = NDArray[np.float64]

SCHEMA = "stiffcal/ingest/1"
_SI = {
    "joints": "rad",
    "joints.command": "rad",
    "joints.velocity": "radps",
    "joints.torque": "Nm",
    "joints.current": "A",
    "mass": "kg",
    "lengths": "m",
    "displacement": "m",
    "translation": "m",
    "rotation": "rad",
    "temperature": "K",
    "hold": "s",
}


@dataclass(frozen=True)
class ReducedCampaign:
    """Load states and the ingest document that tells how they came about."""

    states: LoadStates
    document: dict[str, Any]


def reduce_campaign(campaign: Campaign, progress: Progress, writing: Writing | None = None) -> ReducedCampaign:
    """Read all sources of a campaign and reduce them to load states.

    Parameters
    ----------
    writing : where the recordings go as they stream past; None: nowhere.

    Raises
    ------
    InputError
        A source is faulty, or no load states can be made of it.
    """
    manifest = campaign.manifest
    progress("reading tables", None)
    parts: list[Gathered] = []
    watches = Watches(campaign)
    table = tabled_states(campaign.folder, manifest, watches.see)
    logged = [name for name, source in manifest.sources.items() if not source.is_states]
    runs: list[ReducedRun] = []
    if logged:
        for k, run in enumerate(manifest.runs):
            sources = [name for name in logged if name in run.files]
            if sources:
                reduced = _reduce_logs(campaign, run, sources, progress, k / len(manifest.runs), writing, watches)
                runs.append(reduced)
                parts.append(reduced.states)
    if table is not None:
        parts.insert(0, table)
    if not parts:
        raise InputError.at(
            "campaign.toml",
            "[[runs]]",
            "no run names a file",
            'add [[runs]] with files = { … }, or run = { column = "run" }',
        )
    gathered = stacked(parts)
    progress("making load states", None)
    states, registration = _placed_states(campaign, gathered)
    faults, warnings = contradictions(states, campaign, registration is not None)
    raise_faults(faults)
    states = set_bumped_aside(states)
    document = _document(states, runs)
    document["warnings"] += watches.remarks() + warnings
    if registration is not None:
        document["registration"] = registration.as_document()
    return ReducedCampaign(states, document)


def _placed_states(campaign: Campaign, gathered: Gathered) -> tuple[LoadStates, Registration | None]:
    """Return load states in base axes; frames to be estimated are found first, from the references."""
    manifest, chain = campaign.manifest, campaign.chain
    states = load_states(gathered, manifest, chain, measurement_setup(manifest, chain, resolve_frames(manifest, chain)))
    names = frames_to_estimate(manifest)
    if not names:
        return states, None
    found = register_frames(in_instrument_axes(states), manifest, chain, names)
    setup = measurement_setup(manifest, chain, resolve_frames(manifest, chain, found.frames))
    return load_states(gathered, manifest, chain, setup), found


def _document(states: LoadStates, runs: Sequence[ReducedRun]) -> dict[str, Any]:
    """Return the ingest document: clocks, numbers of states, what was dropped and set aside."""
    by_name = {run.states.run[0]: run for run in runs}
    entries = []
    for number, info in enumerate(states.runs):
        reduced = by_name.get(info.name)
        aside = [
            {"state": int(states.row[k]), "why": str(states.set_aside[k])}
            for k in np.flatnonzero((states.run == number) & ~states.used)
        ]
        entries.append(
            {
                "id": info.name,
                "clock_ahead_s": {}
                if reduced is None
                else {source: offset.as_document() for source, offset in reduced.clocks.items()},
                "n_states": int(((states.run == number) & states.used).sum()),
                "dropped": ([] if reduced is None else _dropped(reduced)) + aside,
            }
        )
    return {
        "schema": SCHEMA,
        "warnings": [warning for run in runs for warning in run.warnings],
        "n_states": int(states.used.sum()),
        "n_set_aside": int((~states.used).sum()),
        "runs": entries,
    }


def _dropped(reduced: ReducedRun) -> list[dict[str, Any]]:
    """Sum up what was dropped of a run's logs, by reason."""
    found: dict[str, list[tuple[float, float]]] = {}
    for stretch in reduced.dropped:
        found.setdefault(stretch.reason, []).append((stretch.start, stretch.end))
    return [
        {
            "why": reason,
            "pieces": len(pieces),
            "seconds": float(sum(end - start for start, end in pieces)),
            "first_s": [float(pieces[0][0]), float(pieces[0][1])],
        }
        for reason, pieces in found.items()
    ]


def _reduce_logs(
    campaign: Campaign,
    run: Run,
    sources: Sequence[str],
    progress: Progress,
    share: float,
    writing: Writing | None,
    watches: Watches,
) -> ReducedRun:
    logs: dict[str, Blocks] = {}
    for k, name in enumerate(sources):
        progress(f"reading {run.files[name]}", share + k / len(sources) / len(campaign.manifest.runs))
        logs[name] = _read_log(campaign, run, name, writing, watches)
    return reduce_run(run, logs, _tabled_holds(campaign, run, sources[0]))


def _read_log(campaign: Campaign, run: Run, name: str, writing: Writing | None, watches: Watches) -> Blocks:
    """Stream one log: into the store as it is, into block averages for everything else."""
    source = campaign.manifest.sources[name]
    averager = BlockAverager()
    stream: TableStream | None = None
    out = {
        row for exclusion in campaign.manifest.exclude
        if exclusion.source == name and exclusion.run in (None, run.id) for row in exclusion.rows
    }  # fmt: skip
    see = partial(watches.see, name, run.files[name])
    for rows in read_rows(campaign.folder, name, source, campaign.manifest.files_of(name, run), see):
        if writing is not None:
            if stream is None:
                stream = writing.stream(f"recordings/{run.id}/{name}", recording_columns(source, rows))
            stream.append(recording_table(source, rows))
        if out:
            keep = ~np.isin(rows.number, list(out))
            averager.add(rows.time[keep], {key: values[:, keep] for key, values in rows.signals.items()})
        else:
            averager.add(rows.time, rows.signals)
    if stream is not None:
        stream.close()
    return averager.blocks()


def recording_columns(source: Source, rows: Rows) -> list[str]:
    """Return a recording's column names: time_s, then component and SI unit, as in ``Fx_N`` or ``target_x_m``."""
    names = ["time_s"]
    for signal, values in rows.signals.items():
        names += _column_names(source, signal, values.shape[0])
    return names


def recording_table(source: Source, rows: Rows) -> dict[str, Floats]:
    """Return a recording's columns of one batch."""
    columns = {"time_s": rows.time}
    for signal, values in rows.signals.items():
        columns |= dict(zip(_column_names(source, signal, values.shape[0]), values, strict=True))
    return columns


def _column_names(source: Source, signal: str, width: int) -> list[str]:
    kind, _, rest = signal.partition(".")
    if signal == "wrench":
        return ["Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm"]
    if kind in ("position", "marker"):
        return [f"{rest}_{axis}_m" for axis in "xyz"]
    if kind == "quaternion":
        return [f"{rest}_q{axis}" for axis in "wxyz"]
    unit = _SI.get(signal, "")
    names = [f"{signal.replace('.', '_')}{k + 1}_{unit}" for k in range(width)]
    if kind == "joints" and source.joints is not None:
        columns = source.joints.groups().get(rest or "position", ())
        names = [f"{column}_{unit}" for column in columns] if len(columns) == width else names
    return names


def _tabled_holds(campaign: Campaign, run: Run, first: str) -> Holds | None:
    """Read the holds that the run's table states, s of the first source's clock."""
    if run.states is None:
        return None
    source = campaign.manifest.sources[first]
    wanted = Wanted(("start", "end"))
    start: list[Floats] = []
    end: list[Floats] = []
    plain = Source()
    for batch in read_batches(campaign.folder, plain, run.states, wanted):
        start.append(batch.numbers["start"])
        end.append(batch.numbers["end"])
    holds = given_holds(np.concatenate(start), np.concatenate(end))
    bad = np.flatnonzero(holds.end <= holds.start)
    if bad.size:
        k = int(bad[0])
        raise InputError.at(
            run.states, f"data row {k + 1}",
            f"the hold ends ({holds.end[k]:g} s) before it starts ({holds.start[k]:g} s)",
            f"give start and end in seconds of the clock of {first} ({source.format or 'its log'})",
        )  # fmt: skip
    return holds
