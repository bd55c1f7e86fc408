"""A force sensor whose zero was set anew within a table of deflections.

There every row has its displacement already, loaded minus unloaded, and no unloaded reading is left to compare with. It
shows in the springs instead: with one constant taken off forces and moments from some row on, joint compliances explain
the table several times as well as without.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import joint_springs
from stiffcal.mistakes.force_zero.moved_zero import LEAST_STEP, Part
from stiffcal.reduction.loads.motion import motion_of

MENDED = 0.3  # of the squares that joint compliances leave
SURE = 12.0  # of F: one such step in a thousand is found at the best place, over tables of random errors
LEAST_ROWS = 4  # before it and after
# Rows that are tried as the first after it; of a longer table every second or third, and a step is as clear there.
MOST_STARTS = 400
SETTLED, MOST_TURNS = 1e-6, 50
# Of columns of unit length: springs and steps that nothing shows stay at zero.
OF_STILL_COLUMN = 1e-10


def rezeroed_table(states: LoadStates, chain: Chain, file: str = "campaign.toml") -> list[str]:
    """Return a line where the forces of a table of deflections are as if zeroed anew from some row on."""
    n = len(states)
    if not states.deflection_given or not states.has_poses or n < 2 * LEAST_ROWS:
        return []
    reading, per_reading, columns = joint_springs(states, chain)
    measured = motion_of(states, chain, all_targets=True).measured
    rows = np.isfinite(measured)
    free = int(rows.sum()) - columns.shape[2] - reading.shape[1] - 1
    if free < 1 or not reading.any():
        return []
    measured, columns = np.where(rows, measured, 0.0), np.where(rows[:, :, None], columns, 0.0)
    unchanged = _misfit(columns * (per_reading @ reading[:, :, None])[:, None, :, 0], measured)
    start, step, misfit = _best_step(reading, per_reading, columns, measured)
    sure = (unchanged - misfit) / (reading.shape[1] + 1) > SURE * misfit / free
    stepped = [part for part in Part if _steps(reading[:, part.columns], step[part.columns])]
    if not sure or misfit > MENDED * unchanged or not stepped:
        return []
    numbers = " and ".join(f"({rounded_readings(step[part.columns], part)}) {part.value}" for part in stepped)
    line = (
        f"{file}: from state {states.row[start]} on, of {n}, forces and deflections agree "
        f"{np.sqrt(unchanged / misfit):.1f} times better with {numbers} subtracted from the readings: was the "
        "sensor zeroed again there? they are used as they are; remove the step in a copy, or split the table"
    )
    return [line]


def rounded_readings(values: Floats, part: Part) -> str:
    """Return readings (3,) as a message lists them."""
    decimals = 1 if part is Part.FORCE else 2
    return ", ".join(f"{value:.0f}" if abs(value) >= 9.5 else f"{value:.{decimals}f}" for value in values)


def _steps(reading: Floats, step: Floats) -> bool:
    """Return whether a step (3,) counts next to the readings (n, 3); forces alone have no moments."""
    largest = float(np.linalg.norm(reading, axis=1).max()) if reading.size else 0.0
    return largest > 0.0 and bool(np.linalg.norm(step) >= LEAST_STEP * largest)


def _best_step(reading: Floats, per_reading: Floats, columns: Floats, measured: Floats) -> tuple[int, Floats, float]:
    """Return the row and the step of the readings that explain most, and the squares left; infinite if not converged.

    Parameters
    ----------
    reading : (n, q) of the force sensor.
    per_reading : (n, J, q) drive torque per unit of reading.
    columns : (n, 3, J) displacement per unit of drive torque.
    measured : (n, 3) displacement.
    """
    n, q = reading.shape
    starts = np.unique(np.linspace(LEAST_ROWS, n - LEAST_ROWS, min(MOST_STARTS, n)).astype(np.int64))
    step, start, misfit = np.zeros(q), int(starts[0]), np.inf
    for _ in range(MOST_TURNS):
        step_before, start_before = step, start
        has_step = (np.arange(n) >= start)[:, None]
        design = columns * (per_reading @ np.where(has_step, reading - step, reading)[:, :, None])[:, None, :, 0]
        compliance = _solve(design.reshape(-1, design.shape[2]), measured.ravel())
        # what one unit of each reading does with these springs; products of the two unknowns are met by the turns
        give = (columns * compliance) @ per_reading
        start, step, misfit = _scan(
            columns * (per_reading @ reading[:, :, None])[:, None, :, 0], -give, measured, starts
        )
        if start == start_before and np.linalg.norm(step - step_before) <= SETTLED * np.linalg.norm(step):
            return start, step, misfit
    return start, step, np.inf


def _scan(springs: Floats, give: Floats, measured: Floats, starts: NDArray[np.int64]) -> tuple[int, Floats, float]:
    """Fit compliances and one step, for every start: springs (n, 3, J), give (n, 3, q), measured (n, 3)."""
    J, q = springs.shape[2], give.shape[2]
    scale = np.maximum(np.sqrt(np.einsum("ncj,ncj->j", springs, springs)), 1e-300)
    springs = springs / scale
    size = max(float(np.sqrt(np.einsum("ncj,ncj->", give, give))), 1e-300)
    give = give / size

    def from_each_start_on(terms: Floats) -> Floats:
        return np.asarray(np.cumsum(terms[::-1], axis=0)[::-1][starts])

    normal = np.zeros((len(starts), J + q, J + q))
    right = np.zeros((len(starts), J + q))
    normal[:, :J, :J] = np.einsum("ncj,nck->jk", springs, springs)
    normal[:, :J, J:] = from_each_start_on(np.einsum("ncj,ncq->njq", springs, give))
    normal[:, J:, :J] = normal[:, :J, J:].swapaxes(1, 2)
    normal[:, J:, J:] = from_each_start_on(np.einsum("ncp,ncq->npq", give, give))
    right[:, :J] = np.einsum("ncj,nc->j", springs, measured)
    right[:, J:] = from_each_start_on(np.einsum("ncq,nc->nq", give, measured))
    normal += OF_STILL_COLUMN * np.eye(J + q)
    solution = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
    misfit = float(np.sum(measured**2)) - np.einsum("sk,sk->s", solution, right)
    k = int(np.argmin(misfit))
    return int(starts[k]), solution[k, J:] / size, max(float(misfit[k]), 1e-300)


def _misfit(design: Floats, measured: Floats) -> float:
    design, target = design.reshape(-1, design.shape[2]), measured.ravel()
    return float(np.sum((target - design @ _solve(design, target)) ** 2))


def _solve(design: Floats, wanted: Floats) -> Floats:
    scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(design / scale, wanted, rcond=1e-9)[0] / scale)
