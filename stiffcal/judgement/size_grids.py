"""Sums over grids of sizes, of coefficients and of discrepancies: each size of a grid stands for its cell.

A size of q coefficients that show is known to 1 / √(2 q) of itself, and that of a discrepancy, which moves readings
along hundreds of directions, to a few hundredths. On a grid that is coarser than that, a plain sum hangs on where the
size lies between two of its points. The log evidence bends little from one to the next, so it is summed along a cubic
spline through them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.judgement.numbers import LEAST_OF_SPLINE, OF_CELL


def log_sum(values: Floats) -> Floats:
    """Return (…) for logarithms (…, g, s) on grids of s sizes that of their sum, cells over all g."""
    fine = _within_cells(values)
    top = fine.max(axis=(-3, -2, -1), keepdims=True)
    return np.asarray(top[..., 0, 0, 0] + np.log(np.sum(np.exp(fine - top), axis=(-3, -2, -1)) / fine.shape[-1]))


def over_cells(values: Floats, kinds: Sequence[slice]) -> Floats:
    """Return (t,) the log of the mean evidence over the cell of each discrepancy, from the log evidence at its size.

    Parameters
    ----------
    kinds : where each kind has its sizes.
    """
    found = values.copy()
    for at in kinds:
        fine = _within_cells(values[at])
        found[at] = np.logaddexp.reduce(fine, axis=-1) - np.log(fine.shape[-1])
    return found


def _within_cells(values: Floats) -> Floats:
    """Return (…, s, k) values (…, s) in the middles of k parts of each cell; of few sizes no more than they are."""
    count = values.shape[-1]
    if count < LEAST_OF_SPLINE:
        return values[..., None]
    return np.asarray(values @ _spline(count, OF_CELL).T).reshape(*values.shape, OF_CELL)


@lru_cache(maxsize=8)
def _spline(count: int, parts: int) -> Floats:
    """Return (count · parts, count) what a cubic spline through values makes in the middles of parts of cells.

    Its third derivative does not jump next to the ends (de Boor, A Practical Guide to Splines, 1978, chapter IV).
    """
    places = (np.arange(count * parts) + 0.5) / parts - 0.5
    left = np.clip(np.floor(places).astype(np.int64), 0, count - 2)
    after = (places - left)[:, None]
    values, inside = np.eye(count), np.arange(1, count - 1)
    # second derivatives d by those of the values v: d[k-1] + 4 d[k] + d[k+1] = 6 (v[k-1] - 2 v[k] + v[k+1])
    system, wanted = np.zeros((count, count)), np.zeros((count, count))
    for k, bends, by in ((-1, 1.0, 6.0), (0, 4.0, -12.0), (1, 1.0, 6.0)):
        system[inside, inside + k], wanted[inside, inside + k] = bends, by
    system[0, :3] = system[-1, -3:] = 1.0, -2.0, 1.0
    bend = np.linalg.solve(system, wanted)
    before = 1.0 - after
    straight = before * values[left] + after * values[left + 1]
    return np.asarray(straight + ((before**3 - before) * bend[left] + (after**3 - after) * bend[left + 1]) / 6.0)
