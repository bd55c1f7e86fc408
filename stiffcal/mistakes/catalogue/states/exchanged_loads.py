"""Two runs of which the loads are exchanged."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.mistakes.states.exchanges import Exchange, RunResponses


class ExchangedLoads(Exchange):
    """Each carried what is entered for the other."""

    name = "exchanged-loads"
    rank = 11
    part = "loads"

    def moved(self, runs: RunResponses, run: int, others: Integers) -> Floats:
        """Return what others' loads do to a run's readings."""
        return np.asarray(runs.response[run] @ (runs.loads_of(others) - runs.loads(run)))
