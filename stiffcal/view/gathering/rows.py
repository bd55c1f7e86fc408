"""Rows of a kind of experiment on the page for a browser, as states with one component: torque over motion."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.kinds.drawn_rows import DrawnRows
from stiffcal.measurements.columns import values_of
from stiffcal.stages.diagnoses.stored_curves import REFITS, ROW_REFITS
from stiffcal.stages.steps import Ingested
from stiffcal.view.content import ViewContent, ViewEffect, ViewRun, ViewStates, ViewVariable
from stiffcal.view.gathering.change import LastAdded
from stiffcal.view.gathering.models import ResidualTables, view_models
from stiffcal.view.gathering.runs import rows_of_logs, with_raw_rows
from stiffcal.view.gathering.sample import picked_model, sample_of

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.results.identify_result import IdentifyResult

_NO_EFFECT = "the model contains no effect at this joint"


def content_of_rows(
    content: ViewContent,
    rows: DrawnRows,
    data: Ingested,
    identified: IdentifyResult,
    reason: str,
    pick: Integers | None,
) -> ViewContent:
    """Return the content with rows as its states: the first of three components is the torque, the others are zero.

    Parameters
    ----------
    content : what else the page shows. rows : n of them.
    data : the campaign. identified : the present fit.
    reason : why there is no diagnosis, "" where there is one.
    pick : which rows are drawn, ascending; None: all, or of many a sample.
    """
    names = list(dict.fromkeys(rows.run.tolist()))
    run = np.array([names.index(name) for name in rows.run.tolist()], dtype=np.int64)
    variables = [
        ViewVariable(
            name=entry.name, label=entry.label, unit=entry.unit, values=entry.values, levels=list(entry.levels)
        )
        for entry in rows.variables
    ]
    if len(names) > 1:
        variables.append(ViewVariable(name="run", label="run", unit="", values=run.astype(np.float64), levels=names))
    last = LastAdded.of(data, identified)
    models = last.remarked(view_models(data, identified, variables, rows.judged, tables_of_rows(rows)))
    present = next((model.residual_fit for model in models if model.present), None)
    if pick is None:
        pick = sample_of(_as_states(rows.measured) if present is None else present)
    described = {entry.id: entry for entry in data.campaign.manifest.runs}
    number = np.zeros(len(run), dtype=np.int64)
    for k in range(len(names)):
        number[run == k] = np.arange(1, np.count_nonzero(run == k) + 1)
    total = float(np.nansum(rows.measured[rows.judged] ** 2))
    drawn = np.full(len(run), -1, dtype=np.int64)
    drawn[pick] = np.arange(len(pick))
    nowhere = np.zeros((0, 3))
    runs = [
        ViewRun(name=name, chain=nowhere, axes=nowhere, holdout=name in described and described[name].holdout,
                files=_files(data, name) if content.raw else [])
        for name in names
    ]  # fmt: skip
    of_log, lines, line_number = (
        np.zeros((len(run), 2), dtype=np.int64),
        [""] * len(pick),
        np.zeros(len(pick), np.int64),
    )
    if content.raw and "pass_start_s" in rows.readings:
        spans = np.stack([rows.readings["pass_start_s"], rows.readings["pass_end_s"]], axis=1)
        runs, of_log = rows_of_logs(data, runs, run, spans)
        runs, lines, line_number = with_raw_rows(data, runs, run[pick], of_log[pick].sum(axis=1) // 2)
    return replace(
        content,
        n_states=len(run),
        fitted_rows=drawn[rows.fitted],
        direction=rows.direction,
        runs=runs,
        states=ViewStates(
            index=pick,
            run=run[pick],
            row=number[pick],
            first_row=of_log[pick, 0],
            last_row=of_log[pick, 1],
            used=rows.judged[pick],
            why=["" if judged else _NO_EFFECT for judged in rows.judged[pick].tolist()],
            lines=lines,
            line_number=line_number,
            measured=_as_states(rows.measured)[pick],
            force=np.zeros((len(pick), 0)),
            shape=np.zeros((len(pick), 0)),
            target=np.zeros((len(pick), 0)),
        ),
        variables=[replace(entry, values=entry.values[pick]) for entry in variables],
        models=[picked_model(model, pick) for model in models],
        change=last.change(models, []),
        effects=[
            ViewEffect(
                name=part.effect,
                joint=part.joint,
                part_of="joint",
                removable=True,
                share=float(np.nansum((part.values * rows.measured)[rows.judged])) / total if total > 0.0 else 0.0,
                part=_as_states(part.values)[pick],
            )
            for part in rows.parts
        ],
        readings={name: values[pick] for name, values in rows.readings.items()} if content.raw else {},
        refits_missing=""
        if any(model.kind in ("with", "all") for model in models)
        else reason or "the store holds no refits: run stiffcal diagnose again",
    )  # fmt: skip


def _as_states(values: Floats) -> Floats:
    """Return (n, 3) of (n,) with zeros in the second and third column."""
    result = np.zeros((len(values), 3))
    result[:, 0] = values
    return result


def tables_of_rows(rows: DrawnRows) -> ResidualTables:
    """Return where the residuals of n rows are."""
    n = len(rows.run)

    def scattered(table: pa.Table, mask: Booleans) -> Floats | None:
        values = values_of(table.column(rows.residual))
        if len(values) != np.count_nonzero(mask) or values_of(table.column("run")).tolist() != rows.run[mask].tolist():
            return None  # a fit of an earlier model, to other rows
        whole = np.full(n, np.nan)
        whole[mask] = values
        return _as_states(whole)

    def of_refit(table: pa.Table) -> Floats:
        whole = np.full(n, np.nan)
        whole[values_of(table.column("row"))] = values_of(table.column("residual"))
        return _as_states(whole)

    return ResidualTables(
        fit=rows.fit_table,
        heldout=rows.heldout_table,
        refits=ROW_REFITS,
        of_fit=lambda table: scattered(table, rows.fitted),
        of_heldout=lambda table: scattered(table, rows.judged),
        of_refit=of_refit,
        documents=(ROW_REFITS, REFITS),
    )


def _files(data: Ingested, name: str) -> list[str]:
    """Return the logs of a run, relative to the campaign folder."""
    manifest = data.campaign.manifest
    run = next((entry for entry in manifest.runs if entry.id == name), None)
    files = [
        file
        for source_name, source in manifest.sources.items()
        if source.in_files
        for file in manifest.files_of(source_name, run).values()
    ]
    return list(dict.fromkeys(files))
