"""Two runs of which the target's places are exchanged."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.mistakes.states.exchanges import Exchange, RunResponses


class ExchangedPlaces(Exchange):
    """Each has what was measured of the other's target."""

    name = "exchanged-places"
    rank = 12
    part = "places"

    def moved(self, runs: RunResponses, run: int, others: Integers) -> Floats:
        """Return what others' places do to a run's readings."""
        return np.asarray(runs.answers_of(others) - runs.answers_of(np.array([run])))
