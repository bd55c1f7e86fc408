"""How probable it is that readings look like copies by chance: of rows in a table, and of whole logs.

What chance does is counted where there are no copies: in the same rows as they would be if their readings ended in
other digits, or between neighbours of one log. Without copies a row of the one kind looks like a copy as often as one
of the other, so that those which do are drawn from both, each row once.
"""

from __future__ import annotations

import math

import numpy as np

MOST_PROBABLE = 1e-3
"""Of copies that are named though there are none, in one table or in all logs of a campaign."""


def probability_of_as_many(alike: int, rows: int, alike_by_chance: int, rows_by_chance: int) -> float:
    """Return how probable it is that so many rows or more look like copies where none is one.

    Parameters
    ----------
    alike : of the `rows` that are judged, those that look like copies.
    alike_by_chance : of the `rows_by_chance` that are known to be no copies, those that do.

    Examples
    --------
    >>> round(probability_of_as_many(3, 40, 0, 360), 6), probability_of_as_many(0, 5, 1, 5)
    (0.000933, 1.0)
    """
    whole, marked = rows + rows_by_chance, alike + alike_by_chance
    if alike <= max(0, marked - rows_by_chance):
        return 1.0
    first = _log_binomial(marked, alike) + _log_binomial(whole - marked, rows - alike) - _log_binomial(whole, rows)
    more = np.arange(alike, min(rows, marked), dtype=np.float64)
    ratios = (marked - more) * (rows - more) / ((more + 1.0) * (whole - marked - rows + more + 1.0))
    terms = first + np.concatenate([[0.0], np.cumsum(np.log(ratios))])
    return min(1.0, float(np.exp(terms).sum()))


def _log_binomial(n: int, k: int) -> float:
    return math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1)
