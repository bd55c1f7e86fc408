"""The run sheet of a plan: what to measure, in order, one load state a row."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.document_arrays import Vector
from stiffcal.escapes import csv_cell
from stiffcal.store.workbook import ENDING, write_workbook
from stiffcal.trust.output_kinds import RUN_SHEET
from stiffcal.trust.outputs import written

CSV, PDF = ".csv", ".pdf"
WORDS = ("run", "state", "log")
"""Columns of words in the run sheet; all others are of numbers."""

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.planning.results import PlanResult


def write_sheet(file: Path, campaign: Campaign, plan: PlanResult, *, overwrite: bool = False) -> None:
    """Write the run sheet, as CSV, workbook or PDF by the file's ending.

    Raises
    ------
    InputError : the file cannot be written, or holds something stiffcal did not write.
    """
    with written(file, RUN_SHEET, overwrite) as temporary:
        if file.suffix.lower() == CSV:
            write_run_sheet(temporary, plan, _logs(campaign))
            return
        if file.suffix.lower() == ENDING:
            head, rows = run_sheet(plan, _logs(campaign))
            write_workbook(temporary, head, (_with_numbers(head, row) for row in rows), "runs")
            return
        from stiffcal.report.run_sheet import build_run_sheet

        today = datetime.now(UTC).date().isoformat()
        robot = campaign.robot.name or "a robot"
        build_run_sheet(plan, robot, campaign.manifest.name or "", _logs(campaign), today, temporary)


def _logs(campaign: Campaign) -> tuple[str, ...]:
    """Return what to log to: the file of a source that has one for all runs, else the source's name."""
    return tuple(
        source.file if source.in_files and source.file is not None else name
        for name, source in campaign.manifest.sources.items()
    )


def write_run_sheet(file: Path, plan: PlanResult, sources: tuple[str, ...]) -> None:
    """Write the run sheet as CSV, text that a spreadsheet takes for a formula marked.

    Parameters
    ----------
    file : to write. plan, sources : as in `run_sheet`.

    Raises
    ------
    OSError : the file cannot be written.
    """
    head, rows = run_sheet(plan, sources)
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([csv_cell.escaped(name) for name in head])
        for row in rows:
            writer.writerow([csv_cell.escaped(cell) if isinstance(cell, str) else cell for cell in row])


def run_sheet(plan: PlanResult, sources: tuple[str, ...]) -> tuple[list[str], list[list[str | int]]]:
    """Return the run sheet, names and rows: run, rank, row in the run, state, joint angles (degrees), forces (N, base).

    Forces of clamped robots are those to be expected at the fixture. Then follow the minutes that the state takes, and
    what to log. The first and the last row of every load run are unloaded. Rows with number 0 are the warm-up and
    poses on the way.

    Parameters
    ----------
    plan : its runs.
    sources : names of the logging devices, or of their files.
    """
    from stiffcal.planning.information import UNLOADED_READINGS

    head = ["run", "rank", "row", "state", *(f"{name} [deg]" for name in plan.joint_names)]
    head += [f"{axis} [N]" for axis in ("Fx", "Fy", "Fz")] + ["minutes", "log"]
    log = " ".join(sources)
    rows: list[list[str | int]] = []
    if plan.warm_up_minutes:
        nothing = [""] * (len(plan.joint_names) + 3)
        rows.append(["", "", 0, "warm-up: move all joints", *nothing, f"{plan.warm_up_minutes:g}", ""])
    for run in plan.runs:
        for joints in run.approach:
            rows.append([run.id, run.rank, 0, "intermediate pose", *_degrees(joints), "", "", "", "", ""])
        first, last = UNLOADED_READINGS[plan.experiment]
        loads = [*[np.zeros(3)] * first, *run.wrench[:, :3], *[np.zeros(3)] * last]
        for number, force in enumerate(loads, start=1):
            state = "loaded" if force.any() else "unloaded"
            state = state if run.moved_joint is None else f"{state}, joint {run.moved_joint} driven"
            forces = [f"{component:.1f}" for component in force + 0.0]
            rows.append(
                [run.id, run.rank, number, state, *_degrees(run.joints), *forces, f"{run.minutes_per_state:g}", log]
            )
    return head, rows


def _with_numbers(head: Sequence[str], row: Sequence[str | int]) -> list[str | float]:
    """Return a row of the run sheet with numbers in place of their texts."""
    named = zip(head, row, strict=True)
    return [cell if name in WORDS or cell == "" else float(cell) for name, cell in named]


def _degrees(joints: Vector) -> list[str]:
    return [f"{angle:.2f}" for angle in np.degrees(joints)]
