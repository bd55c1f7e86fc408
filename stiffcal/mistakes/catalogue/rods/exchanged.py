"""Two rods whose columns, or whose entries, are interchanged."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from stiffcal.mistakes.rods.mended import mended
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings


class ExchangedRods(RodMistake):
    """Each of two rods with the readings of the other."""

    name = "exchanged"
    rank = 12

    def ways(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield each pair of rods exchanged."""
        for pair in combinations(np.flatnonzero(readings.used).tolist(), 2):
            order = np.arange(readings.lengths.shape[1])
            order[list(pair)] = order[list(pair[::-1])]
            words = f"{readings.named(pair)} are interchanged"
            mend = "interchange their columns or their entries in [ids]"
            yield mended(pair, readings, readings.lengths[:, order], words, mend)
