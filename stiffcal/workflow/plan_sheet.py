"""The run sheet of a plan: what to measure, in order, one load state a row."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.escapes import csv_cell
from stiffcal.files import refusal

if TYPE_CHECKING:
    from stiffcal.planning.results import PlanResult


def write_run_sheet(file: Path, plan: PlanResult) -> None:
    """Write the run sheet as CSV: run, rank, row in the run, joint angles (degrees), forces (N, base axes).

    The first and the last row of every run are unloaded.

    Raises
    ------
    InputError : the file cannot be written.
    """
    head = ["run", "rank", "row", *(f"{csv_cell.escaped(name)} [deg]" for name in plan.joint_names)]
    head += [f"{axis} [N]" for axis in ("Fx", "Fy", "Fz")]
    rows = []
    for run in plan.runs:
        angles = [f"{angle:.2f}" for angle in np.degrees(run.joints)]
        loads = [np.zeros(3), *run.wrench[:, :3], np.zeros(3)]
        for number, force in enumerate(loads, start=1):
            rows.append([run.id, run.rank, number, *angles, *(f"{component:.1f}" for component in force)])
    try:
        with file.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows([head, *rows])
    except OSError as error:
        raise (refusal(error) or error) from None
