"""Large campaigns start on some of their runs, long clamped runs on some of their states."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, evenly
from stiffcal.identification.readings.observations import Observations
from stiffcal.reduction.loads.cycles import run_members

# From there the whole needs two steps, and five thousand states give the
# noise to a per cent.
START_STATES, START_RUNS = 5000, 40
# Neighbouring states of a sweep differ by little: so many show all of its curve.
START_SWEPT = 1500


def starting_runs(run: NDArray[np.int64], states: int | None = None) -> Booleans | None:
    """Return (n,) True for the states of every k-th run, so that there are some ``states``; None where few.

    Parameters
    ----------
    run : (n,) run of each state. states : None: `START_STATES`.
    """
    states = START_STATES if states is None else states
    runs = np.unique(run)
    n_runs = max(START_RUNS, len(runs) * states // max(len(run), 1))
    stride = len(runs) // n_runs
    return None if stride < 2 or len(run) < 2 * states else np.isin(run, runs[::stride])


def starting_states(data: Observations) -> Booleans | None:
    """Return (n,) True for the states on which a fit starts; None where these are all."""
    chosen = starting_runs(data.run)
    stride = data.n_states // START_SWEPT
    if chosen is not None or data.clamped is None or stride < 2:
        return chosen
    return np.asarray(np.arange(data.n_states) % stride == 0)


def states_of_long_runs(data: Observations) -> Booleans | None:
    """Return (n,) True for some of each run's states, some `START_STATES` together; None where there are few."""
    if data.n_states < 2 * START_STATES:
        return None
    chosen = np.zeros(data.n_states, dtype=np.bool_)
    for members in run_members(data.run):
        chosen[evenly(members, max(1, members.size * START_STATES // data.n_states))] = True
    return chosen
