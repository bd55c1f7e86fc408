"""A trial of a mistake in rods that gives them other readings and leaves all in use."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mistakes.rods.mistake import RodTrial
from stiffcal.mistakes.rods.readings import RodReadings, squares_left


def mended(rods: tuple[int, ...], readings: RodReadings, lengths: Floats, words: str, mend: str) -> RodTrial:
    """Return the trial with other readings (n, m), m, of some rods; what was wrong, and what to do."""
    without = replace(readings, lengths=lengths)
    size = float(np.sqrt(np.mean((lengths - readings.lengths)[:, list(rods)] ** 2)))
    return RodTrial(rods, without, *squares_left(without), size, words, mend, reads_right=True)
