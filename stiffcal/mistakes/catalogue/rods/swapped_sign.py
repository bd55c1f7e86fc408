"""A rod that reads shorter where it is longer, or all rods, where the load has the wrong sign."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stiffcal.mistakes.rods.mended import mended
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings


class SwappedSign(RodMistake):
    """The other sign of one rod, or of all."""

    name = "swapped-sign"
    rank = 10
    reads_right = True

    def trials(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield each rod with the other sign, and all, which a load that is known contradicts."""
        used = tuple(np.flatnonzero(readings.used).tolist())
        has_load = readings.columns is not None and len(readings.columns) > 0
        for rods in [*((i,) for i in used), *([used] if has_load else [])]:
            sign = np.ones(readings.lengths.shape[1])
            sign[list(rods)] = -1.0
            yield mended(self, rods, readings, readings.lengths * sign)

    def sentence(self, rods: Sequence[str], trial: RodTrial, rms: str) -> str:
        """Return it in words."""
        if len(rods) > 2:
            return f"all rods have the wrong sign, or the load has: {rms}; check acts_on"
        names = " and ".join(rods)
        return f"{names} has the wrong sign: {rms}; change it in the log, or interchange start_m and end_m"
