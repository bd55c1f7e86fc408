"""What a drive carried before, as functions for a law that nobody has written down; nothing where it stays the same.

Followed from state to state of a run, which are in the order in which they were measured.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.judgement.numbers import AVERAGES, STILL


def of_memory(load: Floats, run: Integers | None) -> list[Floats]:
    """Return functions of what was carried before.

    Parameters
    ----------
    load : (n,) over the usual one.
    run : (n,) number of each state's run, the states of a run one after the other; None: they stand alone.
    """
    count = len(AVERAGES) + 5
    found = np.zeros((count, len(load)))
    if run is not None:
        for states in _stretches(run):
            found[:, states] = _of_run(load[states])
    return list(found)


def _stretches(run: Integers) -> Iterator[slice]:
    edges = np.flatnonzero(np.diff(run)) + 1
    starts, ends = [0, *edges.tolist()], [*edges.tolist(), len(run)]
    return (slice(a, b) for a, b in zip(starts, ends, strict=True) if b > a)


def _of_run(load: Floats) -> Floats:
    """Return (8, n) averages of the past, the last load, direction and turn of the load, less the load itself."""
    averages = np.zeros((len(AVERAGES), len(load)))
    kept = np.exp(-1.0 / np.array(AVERAGES))
    last, direction, turned = np.zeros(len(load)), np.zeros(len(load)), np.zeros(len(load))
    mean, way, turn, before = np.full(len(AVERAGES), load[0]), 0.0, load[0], load[0]
    for k, now in enumerate(load.tolist()):
        step = now - before
        if abs(step) > STILL:
            if way and np.sign(step) != way:
                turn = before
            way = float(np.sign(step))
        averages[:, k] = mean - now
        mean = kept * mean + (1.0 - kept) * now
        last[k], direction[k], turned[k] = -step, way, turn - now
        before = now
    size = np.abs(load)
    return np.concatenate([averages, [last, direction, direction * size, turned, direction * np.abs(turned)]])
