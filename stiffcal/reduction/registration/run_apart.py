"""The one run whose joint angles and places contradict those of all others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stiffcal.errors import InputError
from stiffcal.measurements.load_states import LoadStates
from stiffcal.reduction.registration.frames import Registration

# Without the run that is wrong less than this share of the distance is left.
MUCH_BETTER = 0.3
# Readings more than unknowns without it: with fewer the others meet by chance.
LEAST_FREE = 6
# Runs that are left out in turn; of more the others are close to wherever their frames put them.
MOST_RUNS = 40


def run_apart(
    states: LoadStates, missed_m: float, n_unknowns: int, solve: Callable[[LoadStates], Registration]
) -> tuple[str, float] | None:
    """Return the name of the only run without which all others meet, and how far they are apart then, m, rms.

    Parameters
    ----------
    states : unloaded states from which frames were to be found. missed_m : what they are apart, m, rms.
    n_unknowns : components of the frames. solve : finds the frames from other states.

    Returns
    -------
    str, float
        None where there is no such run, or more than one.
    """
    runs = np.unique(states.run)
    if len(runs) > MOST_RUNS:
        return None
    found = []
    for run in runs:
        others = states.select(states.run != run)
        if others.position.size - n_unknowns < LEAST_FREE:
            continue
        try:
            left = solve(others).rms_m
        except InputError:  # they do not meet either
            continue
        if left <= MUCH_BETTER * missed_m:
            found.append((states.runs[int(run)].name, left))
    return found[0] if len(found) == 1 else None
