"""Least squares of a handful of unknowns within bounds, after Stark and Parker (1995).

Why not scipy's: `scipy.optimize` takes a second to import, longer than a check of logs or a small fit takes.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

# Exchanges per unknown: the active set changes by one at a time, and each unknown comes and goes a few times.
MOST_EXCHANGES = 20
# A sum of squares that falls by less than this share of itself has fallen by rounding alone.
LEAST_GAIN = 1e-14


def least_squares(matrix: Floats, wanted: Floats) -> Floats:
    """Return the x (n,) of smallest norm that minimises |matrix x − wanted|, columns taken as equally long.

    Parameters
    ----------
    matrix : (m, n).
    wanted : (m,).
    """
    scale = column_scale(matrix)
    solution, *_ = np.linalg.lstsq(matrix / scale, wanted, rcond=1e-12)
    return np.asarray(solution / scale)


def least_squares_within(
    matrix: Floats, wanted: Floats, lower: Floats, upper: Floats, independent: bool = False
) -> tuple[Floats, Booleans]:
    """Return the x (n,) that minimises |matrix x − wanted| within bounds, and which unknowns lie on one.

    Parameters
    ----------
    matrix : (m, n).
    wanted : (m,).
    lower, upper : (n,), infinite where there is none.
    independent : True where no column is a sum of others: the active set begins where the minimum without bounds is
        out of them. Else as few unknowns as possible leave their bounds.

    Raises
    ------
    InputError : the numbers are too large to calculate with, or the active set does not settle.
    """
    with np.errstate(over="ignore"):
        scale = column_scale(matrix)
    if not (np.isfinite(scale).all() and np.isfinite(wanted).all()):
        reason = f"the sums of squares of {len(lower)} unknowns overflow"
        raise InputError.at(
            FaultCode.READING_IMPLAUSIBLE, "the data", "", reason, "check for readings of implausible size"
        )
    free = least_squares(matrix, wanted)
    if np.all(free >= lower) and np.all(free <= upper):
        return free, np.zeros(len(free), dtype=np.bool_)
    begin = np.clip(free, lower, upper) * scale if independent else None
    solution, at_bound = _within(matrix / scale, wanted, lower * scale, upper * scale, begin)
    low = solution - lower * scale < upper * scale - solution
    return np.where(at_bound, np.where(low, lower, upper), np.clip(solution / scale, lower, upper)), at_bound


def _within(
    unit: Floats, target: Floats, lower: Floats, upper: Floats, begin: Floats | None
) -> tuple[Floats, Booleans]:
    """Return the minimum of |unit x − target|² within bounds, and who is at one, by an active set.

    Stark and Parker 1995. All parameters that have a bound start there, or those that are at one in ``begin``, and are
    let go one by one, the most wanted first: where several do alike, as few as possible leave their bounds. Columns
    that are alike to rounding would be exchanged for each other without end: until the sum of squares falls, each
    leaves its bound once.
    """
    if begin is None:
        start = np.where(np.isfinite(lower), lower, upper)
        free = ~np.isfinite(start)
        x = np.where(free, 0.0, start)
    else:
        x = np.clip(begin, lower, upper)
        free = (x > lower) & (x < upper)
    barred = np.zeros(len(x), dtype=np.bool_)
    least = 1e-12 * float(np.sqrt(np.sum(target**2)))
    smallest = np.inf
    entering = -1
    for _ in range((MOST_EXCHANGES + len(x)) * (len(x) + 1)):
        aim = x.copy()
        if free.any():
            aim[free] = np.linalg.lstsq(unit[:, free], target - unit[:, ~free] @ x[~free], rcond=1e-12)[0]
        beyond = free & ((aim < lower) | (aim > upper))
        steps = np.where(beyond, _step_to(x, aim, lower, upper), np.inf)
        if entering >= 0 and steps[entering] <= 0.0:
            # only rounding wanted it to leave its bound
            free[entering], barred[entering], entering = False, True, -1
            continue
        if beyond.any():
            first = int(np.argmin(steps))
            x = np.where(free, x + steps[first] * (aim - x), x)
            x[first] = lower[first] if aim[first] < lower[first] else upper[first]
            free[first] = False
            continue
        x = aim
        residual = target - unit @ x
        squares = float(residual @ residual)
        if squares < smallest * (1.0 - LEAST_GAIN):
            smallest = squares
            barred[:] = False
        pull = unit.T @ residual
        wanted = np.where(free | barred, 0.0, np.where(x <= lower, pull, 0.0) - np.where(x >= upper, pull, 0.0))
        entering = int(np.argmax(wanted))
        if wanted[entering] <= least:
            break
        free[entering] = barred[entering] = True
    else:
        reason = f"bounded least squares with {len(x)} unknowns do not converge"
        raise InputError.at(
            FaultCode.NO_CONVERGENCE, "model.toml", "effects", reason, "remove effects that are nearly redundant"
        )
    return x, ~free


def _step_to(x: Floats, aim: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return the share of the way from x to its aim at which each parameter meets its bound."""
    bound = np.where(aim < lower, lower, upper)
    distance = np.where(aim == x, 1.0, aim - x)
    return np.asarray(np.clip((np.where(np.isfinite(bound), bound, x + distance) - x) / distance, 0.0, 1.0))


def column_scale(factor: Floats) -> Floats:
    """Return the columns' lengths (1 for columns of zeros)."""
    length = np.sqrt(np.sum(factor * factor, axis=0))
    return np.where(length > 0.0, length, 1.0)
