"""Which states the page for a browser draws where there are many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.view.content import ViewModel

MOST_SHOWN = 5000
"""States that are drawn; of more a sample."""
ALWAYS_SHOWN = 0.1
"""Share of the sample that is kept for the largest residuals."""


def picked_model(model: ViewModel, pick: Integers) -> ViewModel:
    """Return a model with the residuals of the states that are drawn."""
    inside, outside = model.residual_fit, model.residual_heldout
    return replace(
        model,
        residual_fit=None if inside is None else inside[pick],
        residual_heldout=None if outside is None else outside[pick],
    )


def sample_of(residual: Floats) -> Integers:
    """Return the states that are drawn, ascending: all, or those with the largest residuals and evenly of the rest."""
    n = len(residual)
    if n <= MOST_SHOWN:
        return np.arange(n)
    squares = np.nansum(residual[:, :3] ** 2, axis=1)
    largest = np.argsort(-squares, kind="stable")[: int(ALWAYS_SHOWN * MOST_SHOWN)]
    rest = np.setdiff1d(np.arange(n), largest)
    even = rest[np.linspace(0, len(rest) - 1, MOST_SHOWN - len(largest)).astype(np.int64)]
    return np.asarray(np.union1d(largest, even))
