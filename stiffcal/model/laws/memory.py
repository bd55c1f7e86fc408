"""Laws with a memory, over whole runs at once: the play operator and relaxation towards a driven value.

Why scans and not loops: one step of either law is a function of the value before, a clamp x → min(max(x, a), b) or a
straight line x → f x + g. Such functions chain to functions of the same kind, so that all states' histories come out
of log₂(longest run) vectorised doublings (Hillis and Steele 1986), with no loop over states.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers


def first_of_run(run: Integers) -> NDArray[np.bool_]:
    """Return (n,) True where a run begins; states of a run are contiguous."""
    return np.concatenate([[True], run[1:] != run[:-1]]) if run.size else np.zeros(0, dtype=np.bool_)


def play_operator_from_rest(torque: Floats, slip: float) -> Floats:
    """Return (n,) the play operator's value after one monotonic move from zero to ``torque``, N·m."""
    return np.asarray(torque - np.clip(torque, -slip, slip))


def play_operator(torque: Floats, slip: float, run: Integers, start: Floats | None = None) -> Floats:
    """Return the play operator P_r[τ]: the value stays until it is r behind the torque, then follows at that distance.

    P_i = min(max(P_{i-1}, τ_i − r), τ_i + r) (Brokate and Sprekels 1996, section 2.3; a Jenkin element's plastic part).

    Parameters
    ----------
    torque : (n,) N·m, in the order in which it acted; states of a run contiguous.
    slip : r, N·m, not negative.
    run : (n,) run number; the memory is zero at each run's start.
    start : (n,) torque that acts before the run's first state (the weight); the run's first value counts. None: none.

    Returns
    -------
    (n,) N·m.

    Examples
    --------
    >>> import numpy as np
    >>> play_operator(np.array([0.0, 3.0, 5.0, 3.0, 0.0, -2.0]), 1.0, np.zeros(6, dtype=np.int64)).tolist()
    [0.0, 2.0, 4.0, 4.0, 1.0, -1.0]
    """
    first = first_of_run(run)
    before = np.zeros(int(first.sum())) if start is None else play_operator_from_rest(start[first], slip)
    return clamped_between(torque - slip, torque + slip, run, before)


def clamped_between(lower: Floats, upper: Floats, run: Integers, before: Floats) -> Floats:
    """Return x_i = min(max(x_{i-1}, lower_i), upper_i): the generalised play operator of Visintin 1994, section III.2.

    Parameters
    ----------
    lower, upper : (n,) bounds, lower ≤ upper; states of a run contiguous.
    run : (n,) run number.
    before : (R,) value before each of the R runs' first state.

    Examples
    --------
    >>> import numpy as np
    >>> one_run = np.zeros(3, dtype=np.int64)
    >>> clamped_between(np.array([1.0, 0.0, -3.0]), np.array([2.0, 4.0, -1.0]), one_run, np.zeros(1)).tolist()
    [1.0, 1.0, -1.0]
    """
    lower, upper = lower.copy(), upper.copy()
    first = first_of_run(run)
    lower[first] = upper[first] = np.clip(before, lower[first], upper[first])
    step = 1
    # A run's first clamp is a constant: chaining beyond it changes nothing, and so the runs stay apart by themselves.
    while step < len(lower) and (lower != upper).any():
        lower[step:], upper[step:] = (
            np.clip(lower[:-step], lower[step:], upper[step:]),
            np.clip(upper[:-step], lower[step:], upper[step:]),
        )
        step *= 2
    return lower


def relax(keep: Floats, add: Floats, first: NDArray[np.bool_], start: Floats) -> Floats:
    """Return x_i = keep_i x_{i-1} + add_i, from x = start before each run's first state.

    With keep = exp(−Δt/T) and add = (1 − keep) y this is the exact solution of T dx/dt = y − x, y being constant over
    the step.

    Parameters
    ----------
    keep, add, start : (n,); of ``start`` the value at each run's first state counts.
    first : (n,) True where a run begins.

    Returns
    -------
    (n,)

    Examples
    --------
    >>> import numpy as np
    >>> first = np.array([True, False, False])
    >>> relax(np.full(3, 0.5), np.full(3, 1.0), first, np.zeros(3)).tolist()
    [1.0, 1.5, 1.75]
    """
    add = np.where(first, keep * start + add, add)
    keep = np.where(first, 0.0, keep)
    step = 1
    while step < len(add) and keep.any():
        # The right-hand sides are evaluated in full before they are stored: both use the values of the last doubling.
        add[step:], keep[step:] = add[step:] + keep[step:] * add[:-step], keep[step:] * keep[:-step]
        step *= 2
    return add
