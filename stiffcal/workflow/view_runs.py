"""Runs of load states on the page for a browser: their poses, their logs, their raw rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.campaign.manifest import Run
from stiffcal.mechanics.kinematics import body_poses
from stiffcal.reduction.logs import place_of_row, raw_rows_of
from stiffcal.view.content import ViewRun
from stiffcal.workflow.steps import Ingested


def view_runs(data: Ingested, raw: bool) -> list[ViewRun]:
    """Return the runs of load states, with their logs where ``raw`` is set."""
    states, chain, manifest = data.states, data.campaign.chain, data.campaign.manifest
    described = {run.id: run for run in manifest.runs}
    tables = [name for name, source in manifest.sources.items() if source.is_states]
    rows = []
    for info, members in zip(states.runs, states.members(), strict=True):
        joints = states.joints[members[:1]] if len(members) else np.zeros((1, states.joints.shape[1]))
        points, _ = body_poses(chain, chain.model_angles(joints))
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
                holdout=info.holdout,
                files=list(dict.fromkeys(files)),
                source=table,
                own_file=bool(table) and run is not None and table in run.files,
                first_row=_first_row(data, table, run) if table else "",
            )
        )
    return rows


def _first_row(data: Ingested, source: str, run: Run | None) -> str:
    """Return where the first data row of a source's file stands, in words; "" where the file cannot be looked at."""
    settings = data.campaign.manifest.sources[source]
    file = data.campaign.manifest.files_of(source, run).get("")
    if file is None or not settings.in_files or not (data.campaign.folder / file).is_file():
        return ""
    return place_of_row(data.campaign.folder, settings, file, 1)


def with_raw_rows(
    data: Ingested, runs: list[ViewRun], run: Integers, row: Integers
) -> tuple[list[ViewRun], list[str], Integers]:
    """Return the runs with the columns of their files, and the raw rows of states with the numbers of their lines.

    Parameters
    ----------
    data : the campaign.
    runs : of load states. run, row : (n,) of the states that are drawn, as in `ViewStates`.
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
        raw = raw_rows_of(data.campaign.folder, settings, file, row[states].tolist())
        for number in numbers:
            named[number] = replace(runs[number], columns=list(raw.columns))
        for state in states.tolist():
            line_number[state], lines[state] = raw.lines.get(int(row[state]), (0, ""))
    return named, lines, line_number
