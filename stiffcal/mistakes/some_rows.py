"""Of a long table some rows, spread over all of it: as many as decide, in a time that does not grow with the table."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Integers

MOST_ROWS = 300
"""A few hundred poses determine six springs, or the frames of a tracker and its targets, many times over."""


def some_of(count: int, most: int = MOST_ROWS) -> Integers:
    """Return (s,) the rows of a table that are looked at, no more than ``most``.

    Examples
    --------
    >>> some_of(3).tolist(), len(some_of(5000))
    ([0, 1, 2], 300)
    """
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.int64))
