"""Rods that grow with the logged temperature, as neither their expansion nor the link's is stated."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings, left_over, squares_left
from stiffcal.quantity import LENGTH
from stiffcal.wording import in_unit


class WarmingRods(RodMistake):
    """What all rods grow by with the temperature, at one expansion for all."""

    name = "warming"
    rank = 11

    def ways(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield all rods without it, where the load and a temperature that changes are known."""
        if readings.growth is None or readings.columns is None or not len(readings.columns):
            return
        expected = left_over(readings, readings.growth)[:, readings.used].ravel()
        target = left_over(readings, readings.lengths)[:, readings.used].ravel()
        expansion = float(expected @ target / max(float(expected @ expected), np.finfo(float).tiny))
        without = replace(readings, lengths=readings.lengths - expansion * readings.growth)
        squares, numbers = squares_left(without)
        rods = tuple(np.flatnonzero(readings.used).tolist())
        size = float(np.sqrt(np.mean((expansion * readings.growth) ** 2)))
        per_kelvin = in_unit(expansion, LENGTH.unit_for([expansion]))
        words = f"all rods grow with the logged temperature, {per_kelvin} per metre and kelvin"
        mend = "write expansion_per_K of the link ([links] in robot.toml) and of each rod ([ids])"
        # temperatures change over hours
        yield RodTrial(rods, without, squares, numbers + 1, size, words, mend, grows_slowly=True)
