"""Runs of load states on the page for a browser: their poses, their logs, their raw rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.ingest.reading.recording_tables import recording_name
from stiffcal.measurements.columns import values_of
from stiffcal.mechanics.kinematics import body_poses
from stiffcal.reduction.logs.log_rows import place_of_row, raw_rows_of
from stiffcal.stages.steps import Ingested
from stiffcal.view.content import ViewRun


def view_runs(data: Ingested, raw: bool, with_frames: bool, known: Mapping[str, str]) -> list[ViewRun]:
    """Return the runs of load states.

    Parameters
    ----------
    data : the campaign. raw : whether with their logs. with_frames : whether with whole frames for bodies to lie in.
    known : where the first data row of a run's log stands, in words, by the run; of others the log is looked at.
    """
    states, chain, manifest = data.states, data.campaign.chain, data.campaign.manifest
    described = {run.id: run for run in manifest.runs}
    tables = [name for name, source in manifest.sources.items() if source.is_states]
    rows = []
    for info, members in zip(states.runs, states.members(), strict=True):
        joints = states.joints[members[:1]] if len(members) else np.zeros((1, states.joints.shape[1]))
        points, rotations = body_poses(chain, chain.model_angles(joints))
        run = described.get(info.name)
        files: list[str] = []
        if raw:
            for name, source in manifest.sources.items():
                files += manifest.files_of(name, run).values() if source.in_files else []
        table = tables[0] if tables and raw else ""
        rows.append(
            ViewRun(
                name=info.name,
                chain=points[0],
                axes=rotations[0, 1:-1, :, 2],
                across=rotations[0, 1:-1, :, 0] if with_frames else np.zeros((0, 3)),
                holdout=info.holdout,
                files=list(dict.fromkeys(files)),
                source=table,
                own_file=bool(table) and run is not None and table in run.files,
                first_row=_first_row(data, table, run, info.name, known) if table else "",
            )
        )
    return rows


def _first_row(data: Ingested, source: str, run: Run | None, name: str, known: Mapping[str, str]) -> str:
    """Return where the first data row of a source's file stands, in words; "" where the file cannot be looked at."""
    if name in known:
        return known[name]
    settings = data.campaign.manifest.sources[source]
    file = data.campaign.manifest.files_of(source, run).get("")
    if file is None or not settings.in_files or not (data.campaign.folder / file).is_file():
        return ""
    return place_of_row(data.campaign.folder, settings, file, 1)


def spans_of_sweeps(run: Integers, time: Floats) -> Floats:
    """Return (n, 2) s how far states that follow one another at once reach: half the way to the next.

    Parameters
    ----------
    run, time : (n,) of all states, index into the runs, and s; NaN of those that do not follow one another.
    """
    spans = np.full((len(run), 2), np.nan)
    for number in np.unique(run):
        members = np.flatnonzero((run == number) & np.isfinite(time))
        if len(members) > 1:
            ordered = members[np.argsort(time[members], kind="stable")]
            at = time[ordered]
            edges = np.concatenate(
                [[1.5 * at[0] - 0.5 * at[1]], 0.5 * (at[1:] + at[:-1]), [1.5 * at[-1] - 0.5 * at[-2]]]
            )
            spans[ordered] = np.stack([edges[:-1], edges[1:]], axis=1)
    return spans


def rows_of_logs(data: Ingested, runs: list[ViewRun], run: Integers, spans: Floats) -> tuple[list[ViewRun], Integers]:
    """Return the runs with the log that their states were found in, and the states' first and last rows in it, (n, 2).

    Rows are known of runs whose only log is a file of their own: it has one clock. Others get zeros.

    Parameters
    ----------
    data : the campaign. runs : of the page.
    run : (n,) of all states, index into the runs. spans : (n, 2) s, their stretches of the log; NaN where not known.
    """
    named, rows = list(runs), np.zeros((len(run), 2), dtype=np.int64)
    described = {entry.id: entry for entry in data.campaign.manifest.runs}
    for number, entry in enumerate(runs):
        files = described[entry.name].files if entry.name in described else {}
        members = np.flatnonzero((run == number) & np.isfinite(spans).all(axis=1))
        if entry.source or len(files) != 1 or not len(members):
            continue
        (source,) = files
        name = recording_name(entry.name, source)
        if name not in data.store.tables:
            continue
        logged = values_of(data.store.read_table(name, ["time_s"]).column("time_s"))
        if not np.all(np.diff(logged) > 0.0):
            continue
        first = np.searchsorted(logged, spans[members, 0], side="left")
        last = np.searchsorted(logged, spans[members, 1], side="right")
        within = last > first
        rows[members[within]] = np.stack([first + 1, last], axis=1)[within]
        named[number] = replace(entry, source=source, own_file=True, is_sampled=True)
    return named, rows


def with_raw_rows(
    data: Ingested, runs: list[ViewRun], run: Integers, row: Integers
) -> tuple[list[ViewRun], list[str], Integers]:
    """Return the runs with the columns of their files, and the raw rows of states with the numbers of their lines.

    Parameters
    ----------
    data : the campaign.
    runs : of the page. run : (n,) of the states that are drawn, as in `ViewStates`.
    row : (n,) a data row of each; 0 where none is known.
    """
    manifest = data.campaign.manifest
    described = {entry.id: entry for entry in manifest.runs}
    files: dict[str, list[int]] = {}
    for number, entry in enumerate(runs):
        source = manifest.sources.get(entry.source)
        if source is not None and source.in_files:
            file = manifest.files_of(entry.source, described.get(entry.name)).get("")
            if file is not None and (data.campaign.folder / file).is_file():
                files.setdefault(file, []).append(number)
    lines, line_number, named = [""] * len(run), np.zeros(len(run), dtype=np.int64), list(runs)
    for file, numbers in files.items():
        states = np.flatnonzero(np.isin(run, numbers))
        settings = manifest.sources[runs[numbers[0]].source]
        raw = raw_rows_of(data.campaign.folder, settings, file, row[states][row[states] > 0].tolist())
        for number in numbers:
            named[number] = replace(runs[number], columns=list(raw.columns))
        for state in states.tolist():
            line_number[state], lines[state] = raw.lines.get(int(row[state]), (0, ""))
    return named, lines, line_number
