"""What a drive carried before, as functions for a law that nobody has written down; nothing where it stays the same.

Followed from state to state of a run, which are in the order in which they were measured.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement.numbers import AVERAGES, STILL
from stiffcal.model.laws.memory import first_of_run


def of_memory(load: Floats, run: Integers | None) -> list[Floats]:
    """Return averages of the past, the last load, direction and turn of the load, less the load itself.

    Parameters
    ----------
    load : (n,) over the usual one.
    run : (n,) number of each state's run, the states of a run one after the other; None: they stand alone.
    """
    found = np.zeros((len(AVERAGES) + 5, len(load)))
    if run is None:
        return list(found)
    first = np.flatnonzero(first_of_run(run))
    length, kept = np.diff(np.append(first, len(run))), np.exp(-1.0 / np.array(AVERAGES))[:, None]
    mean, way, turn, before = np.tile(load[first], (len(AVERAGES), 1)), np.zeros(len(first)), load[first], load[first]
    # the first states of all runs, then the second ones, …
    for k in range(int(length.max(initial=0))):
        own = np.flatnonzero(length > k)
        at = first[own] + k
        now, last = load[at], before[own]
        moved, sense = np.abs(now - last) > STILL, np.sign(now - last)
        turn[own] = np.where(moved & (way[own] != 0.0) & (sense != way[own]), last, turn[own])
        way[own] = direction = np.where(moved, sense, way[own])
        found[: len(AVERAGES), at] = mean[:, own] - now
        mean[:, own] = kept * mean[:, own] + (1.0 - kept) * now
        since = turn[own] - now
        found[len(AVERAGES) :, at] = last - now, direction, direction * np.abs(now), since, direction * np.abs(since)
        before[own] = now
    return list(found)
