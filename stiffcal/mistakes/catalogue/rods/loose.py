"""A rod that does not follow the link: its fixing slips."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    leaves_out = True

    def trials(self, readings: RodReadings) -> Iterator[RodTrial]:
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
        yield RodTrial(self, (rod,), left, squares, numbers + len(off), size)
        if readings.columns is not None:
            only_rod = np.zeros(len(readings.used), dtype=np.bool_)
            only_rod[rod] = True
            alone, more = squares_left(replace(readings, used=only_rod, signed=False))
            yield RodTrial(self, (rod,), left, squares + alone, numbers + more, size)

    def sentence(self, rods: Sequence[str], trial: RodTrial, rms: str) -> str:
        """Return it in words."""
        names = " and ".join(rods)
        return (
            f"{names} does not follow the link ({length_in_words(trial.size)} rms): without it {rms}; check its fixing"
        )

    def is_large(self, trial: RodTrial, readings: RodReadings) -> bool:
        """Return whether the rod is further from the others than a link that is no even beam makes it."""
        (rod,) = trial.rods
        should = np.sqrt(np.mean((readings.lengths - left_over(trial.mended, readings.lengths))[:, rod] ** 2))
        return bool(trial.size > max(LOOSE * should, CLEARLY * readings.sigma))
