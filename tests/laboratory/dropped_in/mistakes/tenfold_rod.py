"""A rod whose amplifier stands on the next range, and gives ten times its reading."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stiffcal.mistakes.rods.mended import mended
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings


class TenfoldRod(RodMistake):
    """A tenth of the readings of one rod."""

    name = "tenfold"
    reads_right = True

    def trials(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield the readings with those of each rod divided by ten."""
        for rod in np.flatnonzero(readings.used).tolist():
            lengths = readings.lengths.copy()
            lengths[:, rod] /= 10.0
            yield mended(self, (rod,), readings, lengths)

    def sentence(self, rods: Sequence[str], trial: RodTrial, rms: str) -> str:
        """Return it in words."""
        return f"{rods[0]} reads ten times too much: {rms}; correct the range of its amplifier"
