"""Two rods whose columns, or whose entries, are interchanged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from stiffcal.mistakes.rods.mended import mended
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings


class ExchangedRods(RodMistake):
    """Each of two rods with the readings of the other."""

    name = "exchanged"
    rank = 12
    reads_right = True

    def trials(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield each pair of rods exchanged."""
        for a, b in combinations(np.flatnonzero(readings.used).tolist(), 2):
            order = np.arange(readings.lengths.shape[1])
            order[[a, b]] = order[[b, a]]
            yield mended(self, (a, b), readings, readings.lengths[:, order])

    def sentence(self, rods: Sequence[str], trial: RodTrial, rms: str) -> str:
        """Return it in words."""
        return f"{' and '.join(rods)} are interchanged: {rms}; interchange their columns or their entries in [ids]"
