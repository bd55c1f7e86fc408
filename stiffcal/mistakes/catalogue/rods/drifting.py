"""A rod whose gauge drifts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mistakes.rods.mistake import RodMistake, RodTrial
from stiffcal.mistakes.rods.readings import RodReadings, centred_by_run, count_of, left_over, squares_left
from stiffcal.mistakes.rods.words import length_in_words

# A rate and its bend.
NUMBERS = 2


class DriftingRod(RodMistake):
    """What grows with the time since each run began, bent by a square, taken out of one rod."""

    name = "drifting"
    rank = 13

    def ways(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield each rod without its drift, where times are known."""
        for rod in np.flatnonzero(readings.used).tolist() if readings.time is not None else ():
            yield self._without(rod, readings)

    def _without(self, rod: int, readings: RodReadings) -> RodTrial:
        time = _since_start(readings)
        span = max(float(time.max()), 1e-12)
        columns = np.zeros((NUMBERS, *readings.lengths.shape))
        columns[0, :, rod], columns[1, :, rod] = time / span, (time / span) ** 2
        centred = np.stack([centred_by_run(readings.run, column) for column in columns])
        drifts = [left_over(readings, column)[:, readings.used].ravel() for column in centred]
        target = left_over(readings, readings.lengths)[:, readings.used].ravel()
        rate = np.linalg.lstsq(np.stack(drifts, axis=1), target, rcond=None)[0]
        without = replace(readings, lengths=readings.lengths - np.einsum("p,pnm->nm", rate, centred))
        squares, numbers = squares_left(without)
        size = float(np.sqrt(np.mean((rate @ columns[:, :, rod]) ** 2)))
        words = f"{readings.named([rod])} drifts by {length_in_words(size)} rms within a run"
        mend = "let the gauge warm up, or zero it more often"
        # more than all that is left without it
        slowly = size > np.sqrt(squares / count_of(readings))
        return RodTrial((rod,), without, squares, numbers + NUMBERS, size, words, mend, grows_slowly=bool(slowly))


def _since_start(readings: RodReadings) -> Floats:
    """Return (n,) seconds since each run's first state: gauges are zeroed with each run."""
    time = np.zeros(len(readings.lengths)) if readings.time is None else readings.time
    if readings.run is None:
        return time
    begun = time.copy()
    for run in np.unique(readings.run):
        begun[readings.run == run] = time[readings.run == run].min()
    return np.asarray(time - begun)
