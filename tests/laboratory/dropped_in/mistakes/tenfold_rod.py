"""A rod whose amplifier stands on the next range, and gives ten times its reading."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.rods.mended import mended
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings


class TenfoldRod(RodMistake):
    """A tenth of the readings of one rod."""

    name = "tenfold"

    def ways(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield the readings with those of each rod divided by ten."""
        for rod in np.flatnonzero(readings.used).tolist():
            lengths = readings.lengths.copy()
            lengths[:, rod] /= 10.0
            words = f"{readings.named([rod])} reads ten times too much"
            yield mended((rod,), readings, lengths, words, "correct the range of its amplifier")
