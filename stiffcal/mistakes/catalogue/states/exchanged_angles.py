"""Two runs of which the joint angles are exchanged."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.mistakes.states.exchanges import Exchange, RunResponses


class ExchangedAngles(Exchange):
    """Each was measured in the pose that is entered for the other."""

    name = "exchanged-angles"
    rank = 10
    part = "angles"
    of_one_length = False

    def moved(self, runs: RunResponses, run: int, others: Integers) -> Floats:
        """Return what others' poses do to a run's readings."""
        return np.asarray((runs.response[others] - runs.response[run]) @ runs.loads(run))
