"""The campaign: poses, loads, sensors, and what was set aside and why."""

from __future__ import annotations

import math

import numpy as np

from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.quantity import LENGTH, ShownUnit, of_joint
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Facts,
    Items,
    LeftOut,
    Paragraph,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import ReportContent, ReportStates

ORDER = 20
MOST_WARNINGS = 4
"""More warnings are listed here, not on the first page."""
MOST_RUNS_HERE = 24
"""More runs are listed in an appendix."""
_MOST_ANGLE_COLUMNS = 8
_FROM_NOMINAL = "from the nominal robot"
_TITLE = "The campaign"


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out what was measured, with what, and what was not used."""
    if not content.runs:
        return LeftOut(_TITLE, "no runs are known")
    blocks: list[Block] = [Facts(_facts(content))]
    if content.instruments:
        blocks.append(_instruments(content))
    if len(content.runs) <= MOST_RUNS_HERE:
        blocks.append(runs_table(content))
    else:
        blocks.append(
            Paragraph(f"The {len(content.runs)} {_noun(content)}s with their joint angles are listed in an appendix.")
        )
    if len(warnings := warnings_of(content)) > MOST_WARNINGS:
        blocks += [SubheadingBlock("Warnings"), Items(tuple(warnings))]
    if content.set_aside:
        blocks += [SubheadingBlock("Readings set aside"), _set_aside(content)]
    return ReportSection(_TITLE, tuple(blocks))


def warnings_of(content: ReportContent) -> list[str]:
    """Return the warnings of all steps, each once."""
    results = (content.ingest, content.identify, content.validate)
    return list(dict.fromkeys(text for result in results if result is not None for text in result.warnings))


def _facts(content: ReportContent) -> tuple[tuple[str, str], ...]:
    rows = [("robot", f"{content.provenance.robot}, {wording.count(len(content.joint_names), 'joint')}")]
    holdouts = [run.name for run in content.runs if run.holdout]
    noun = _noun(content)
    runs = wording.count(len(content.runs), noun)
    rows.append((f"{noun}s", runs + (f"; never fitted (holdout): {wording.listing(holdouts)}" if holdouts else "")))
    states = content.states
    if states is None or not states.used.any():
        fit = content.identify
        if fit is None or not fit.n_states or not fit.has_states:
            return (*rows, ("load states", "none"))
        return (*rows, ("states of clamped runs", f"{wording.count(fit.n_states, 'state')} used"))
    load, deflection = states.load[states.used], np.linalg.norm(states.measured[states.used, :3], axis=1)
    directions = [label for label in dict.fromkeys(states.direction[states.used].tolist()) if label]
    n_references = 0 if states.reference is None else int(states.reference.sum())
    besides = f", and {wording.count(n_references, 'reference')}" if n_references else ""
    rows.append(("load states used", wording.count(int(states.used.sum()), "state") + besides))
    if directions:
        rows.append(("directions of force", wording.listing(directions, 12)))
    if load.max() > 0.0:
        rows.append(("loads", f"up to {wording.significant(float(load.max()))} N"))
    if np.isfinite(deflection).any():  # clamped states have none
        rows.append((_largest(content), wording.length(float(np.nanmax(deflection)))))
    what = "position" if content.absolute_alone else "displacement"
    rows.append(("measured", f"{what} and rotation" if states.has_rotation else f"{what}, no rotation"))
    return tuple(rows)


def _instruments(content: ReportContent) -> TableBlock:
    columns = (
        TableColumn("source", align="left"), TableColumn("measures", align="left", width=1.2),
        TableColumn("how", align="left", width=1.4), TableColumn("rate", "1/s"),
        TableColumn("standard uncertainty", align="left", width=1.0),
    )  # fmt: skip
    rows = tuple(
        (
            instrument.source,
            instrument.measures,
            instrument.detail,
            "averaged" if instrument.rate is None else wording.significant(instrument.rate),
            instrument.sigma or "not given",
        )
        for instrument in content.instruments
    )
    averaged = any(instrument.rate is None for instrument in content.instruments)
    caption = "Instruments." + " Averaged: the log has one row for each load state, no rate." * averaged
    return TableBlock(columns, rows, caption)


_MOST_BARE = 8
"""Runs without a pose that are listed by name."""


def runs_table(content: ReportContent) -> TableBlock:
    """Return the table of all runs."""
    few = len(content.joint_names) <= _MOST_ANGLE_COLUMNS
    finite = any(np.isfinite(run.joints).any() for run in content.runs)
    angles = content.joint_names if few and finite else ()
    slides = content.prismatic_joints
    of_joints = [TableColumn(name, of_joint(k in slides).usual.name) for k, name in enumerate(angles, start=1)]
    columns = [TableColumn("run", align="left"), *of_joints]
    states = content.states
    loads = states is not None and _lists_loads(content, states)
    if states is not None:
        if loads:
            columns += [TableColumn("states"), TableColumn("largest load", "N")]
        unit = LENGTH.unit_for([float(np.linalg.norm(states.measured[states.used, :3], axis=1).max(initial=0.0))])
        columns += [TableColumn(name, unit.name) for name in _lengths(content)]
        if states.set_aside is not None and (states.set_aside != "").any():
            columns.append(TableColumn("set aside", "states"))
    rows = []
    for number, run in enumerate(content.runs):
        cells = [run.name.replace(" ", "\u00a0") + (" (holdout)" if run.holdout else "")]
        joints = enumerate(run.joints, start=1) if angles else ()
        positions = [float(of_joint(k in slides).usual.factor * joint) for k, joint in joints]
        # adding zero makes no difference but to a rounded −0.0
        cells += [
            f"{round(angle, 1) + 0.0:.1f}".replace("-", "−") if math.isfinite(angle) else wording.DASH
            for angle in positions
        ]
        if states is not None:
            n_states, load, length, *further = _run_cells(states, number, unit)
            at = min(1, len(_lengths(content)) - 1) if run.measures is StateMeasure.PLACE else 0
            lengths = [length if k == at else wording.DASH for k in range(len(_lengths(content)))]
            cells += [*((n_states, load) if loads else ()), *lengths, *further]
        rows.append(tuple(cells[: len(columns)]))
    several = len(_lengths(content)) > 1
    lengths_text = (
        "loads, deflections, and distances of places from the nominal ones" if several else "loads and deflections"
    )
    caption = "Runs: logged joint angles (mean over the run)" + (f", {lengths_text}." if states is not None else ".")
    if content.absolute_alone:
        loads_too = ", loads" if loads else ""
        caption = f"Poses: logged joint angles{loads_too} and distances of the measured from the nominal positions."
    bare = [row[0] for row in rows if all(cell == wording.DASH for cell in row[1:])]
    if finite and bare:
        rows = [row for row in rows if row[0] not in bare]
        caption += f" Without a pose: {wording.listing(bare, _MOST_BARE)}."
    if not finite:
        columns += [TableColumn("experiment", align="left"), TableColumn("tags", align="left", width=1.0)]
        rows = [(*row, run.kind, ", ".join(run.tags)) for row, run in zip(rows, content.runs, strict=True)]
        caption = "Runs with moving joints, without load states."
    return TableBlock(tuple(columns), tuple(rows), caption)


def _lengths(content: ReportContent) -> tuple[str, ...]:
    """Return the titles of the columns of lengths: deflections, distances of places, or both of runs of both kinds."""
    if content.absolute_alone:
        return (_FROM_NOMINAL,)
    places = any(run.measures is StateMeasure.PLACE for run in content.runs)
    return ("largest deflection", _FROM_NOMINAL) if places else ("largest deflection",)


def _lists_loads(content: ReportContent, states: ReportStates) -> bool:
    """Return whether runs have states and loads worth a column each: absolute poses without a load have none."""
    return not content.absolute_alone or bool((states.load[states.used] > 0.0).any())


def _noun(content: ReportContent) -> str:
    return "pose" if content.absolute_alone else "run"


def _largest(content: ReportContent) -> str:
    return "largest distance from the nominal robot" if content.absolute_alone else "largest deflection"


def _run_cells(states: ReportStates, number: int, unit: ShownUnit) -> list[str]:
    inside = states.used & (states.run == number)
    cells = [str(int(inside.sum()))]
    if inside.any():
        largest = float(np.linalg.norm(states.measured[inside, :3], axis=1).max())
        cells += [wording.significant(float(states.load[inside].max())), wording.significant(largest * unit.factor)]
    else:
        cells += [wording.DASH, wording.DASH]
    if states.set_aside is not None:
        cells.append(str(int(((states.set_aside != "") & (states.run == number)).sum())))
    return cells


def _set_aside(content: ReportContent) -> TableBlock:
    columns = (
        TableColumn("run", align="left"),
        TableColumn("rows", align="left", width=0.6),
        TableColumn("why", align="left", width=1.4),
    )
    rows = tuple(
        (
            rows_set_aside.run or "all",
            wording.listing([str(row) for row in rows_set_aside.rows], 20),
            rows_set_aside.why,
        )
        for rows_set_aside in content.set_aside
    )
    caption = (
        "Readings that were not used. They were set aside before any model was fitted, independent of the error of "
        "the model."
    )
    return TableBlock(columns, rows, caption)
