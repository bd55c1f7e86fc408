"""A rod that does not follow the link: its fixing slips."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings, left_over, squares_left
from stiffcal.mistakes.rods.words import length_in_words

# A rod that is off by less than this share of what it should read is not called loose: sections taper, links shear …
LOOSE = 0.20
# … nor one that is off by less than twice its noise.
CLEARLY = 2.0


class LooseRod(RodMistake):
    """A rod left out; where the load is known it answers that in its own way, for fewer free numbers."""

    name = "loose"
    rank = 14

    def ways(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield the readings without each rod, where the others still hold each other, or the load holds them."""
        for rod in np.flatnonzero(readings.used).tolist():
            used = readings.used.copy()
            used[rod] = False
            if readings.columns is not None or int(used.sum()) > len(readings.design.carried):
                yield from self._without(rod, readings, replace(readings, used=used))

    def _without(self, rod: int, readings: RodReadings, left: RodReadings) -> Iterator[RodTrial]:
        squares, numbers = squares_left(left)
        off = left_over(left, readings.lengths)[:, rod]
        size = float(np.sqrt(np.mean(off**2)))
        should = float(np.sqrt(np.mean((readings.lengths[:, rod] - off) ** 2)))
        if not size > max(LOOSE * should, CLEARLY * readings.sigma):
            return
        words = f"{readings.named([rod])} does not follow the link ({length_in_words(size)} rms)"
        trial = RodTrial((rod,), left, squares, numbers + len(off), size, words, "check its fixing", leaves_out=True)
        yield trial
        if readings.columns is not None:
            only_rod = np.zeros(len(readings.used), dtype=np.bool_)
            only_rod[rod] = True
            alone, more = squares_left(replace(readings, used=only_rod, signed=False))
            yield replace(trial, squares=squares + alone, numbers=numbers + more)
