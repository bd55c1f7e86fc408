"""A rod that reads shorter where it is longer, or all rods, where the load has the wrong sign."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mistakes.rods.mended import mended
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings


class SwappedSign(RodMistake):
    """The other sign of one rod, or of all."""

    name = "swapped-sign"
    rank = 10

    def ways(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield each rod with the other sign, and all, which a load that is known contradicts."""
        used = tuple(np.flatnonzero(readings.used).tolist())
        for rod in used:
            words = f"{readings.named([rod])} has the wrong sign"
            mend = "change it in the log, or interchange start_m and end_m"
            yield mended((rod,), readings, self._swapped(readings, [rod]), words, mend)
        if readings.columns is not None and len(readings.columns) > 0:
            words = "all rods have the wrong sign, or the load has"
            yield mended(used, readings, self._swapped(readings, used), words, "check acts_on")

    def _swapped(self, readings: RodReadings, rods: Sequence[int]) -> Floats:
        lengths = readings.lengths.copy()
        lengths[:, list(rods)] *= -1.0
        return lengths
