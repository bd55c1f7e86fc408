"""Large campaigns start on some of their runs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans

# From there the whole needs two steps, and five thousand states give the
# noise to a per cent.
START_STATES, START_RUNS = 5000, 40


def starting_runs(run: NDArray[np.int64]) -> Booleans | None:
    """Return (n,) True for the states of every k-th run, so that there are some `START_STATES`; None where few."""
    runs = np.unique(run)
    n_runs = max(START_RUNS, len(runs) * START_STATES // max(len(run), 1))
    stride = len(runs) // n_runs
    return None if stride < 2 or len(run) < 2 * START_STATES else np.isin(run, runs[::stride])
