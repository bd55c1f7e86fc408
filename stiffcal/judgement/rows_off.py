"""Single readings that are off: a target that was touched, a line of a table that was typed wrong, noise with tails."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.judgement.ground import Ground
from stiffcal.judgement.numbers import FAR, LEAST_ALONE, ROWS_KEPT


class Off(NamedTuple):
    """A run that is off, or one of its states."""

    run: int
    """Its number."""
    state: int | None = None
    """Number of the state in the campaign; None: the whole run."""


def off_mask(run: Integers, state: Integers, off: Iterable[Off]) -> Booleans:
    """Return (n,) True for states of runs that are off, and for those that are off alone.

    Parameters
    ----------
    run, state : (n,) numbers of each state's run and of itself.
    """
    every = list(off)
    runs = [one.run for one in every if one.state is None]
    return np.asarray(np.isin(run, runs) | np.isin(state, [one.state for one in every if one.state is not None]))


def rows_off(ground: Ground, wanted: frozenset[int] | None = None) -> Iterator[tuple[Off, Floats]]:
    """Give states and (d, r) whitened columns by which each alone may be off, one noise of each component.

    Parameters
    ----------
    wanted : numbers of the states; None: those that are furthest from the model.
    """
    data, scale = ground.space.data, ground.space.scale
    _, position, count = np.unique(data.run, return_inverse=True, return_counts=True)
    far = np.abs(ground.white.reshape(data.measured_mask.shape)).max(axis=0, initial=0.0)
    if wanted is None:
        able = np.flatnonzero((far > FAR) & ((count[position] >= LEAST_ALONE) | data.absolute))
        chosen = able[np.argsort(-far[able], kind="stable")][:ROWS_KEPT]
    else:
        chosen = np.flatnonzero(np.isin(data.index, sorted(wanted)))
    for k in chosen:
        measured = np.flatnonzero(data.measured_mask[:, k] & (scale[:, k] > 0.0))
        moved = np.zeros((len(measured), *data.measured_mask.shape))
        moved[np.arange(len(measured)), measured, k] = 1.0 / scale[measured, k]
        yield Off(int(data.run[k]), int(data.index[k])), ground.space.rows(moved)
