"""How much of a residual a variable explains."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats

BINS = 12
FEWEST = 24
"""Fewer states than this are not cut into bins."""


def share_explained(values: Floats, residual: Floats, levels: bool) -> float:
    """Return the share of a residual's variance that goes with a variable, the number of bins accounted for.

    The variable is cut into up to `BINS` bins of like counts (a variable with levels into these); the share is
    1 − (S_w / (n − k)) / (S_t / (n − 1)), with S_w the squares about the k bins' means and S_t about the mean of all n.

    Parameters
    ----------
    values, residual : (n,); states where one is not finite are left out.
    levels : whether the values are numbers of levels.

    Returns
    -------
    float
        0 to 1.

    Examples
    --------
    >>> x = np.linspace(-1.0, 1.0, 240)
    >>> round(share_explained(x, np.sign(x), False), 6), share_explained(x, np.tile([-1.0, 1.0], 120), False)
    (1.0, 0.0)
    """
    keep = np.isfinite(values) & np.isfinite(residual)
    values, residual = values[keep], residual[keep]
    total = float(np.sum((residual - residual.mean()) ** 2)) if len(residual) else 0.0
    if len(residual) < FEWEST or total <= 0.0 or values.min() == values.max():
        return 0.0
    if levels:
        _, number = np.unique(values, return_inverse=True)
    else:
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))
        number = np.searchsorted(edges, values, side="right")
    count = np.bincount(number)
    mean = np.bincount(number, weights=residual) / np.maximum(count, 1)
    within = float(np.sum((residual - mean[number]) ** 2))
    n, k = len(residual), int(np.count_nonzero(count))
    if n <= k:
        return 0.0
    return float(np.clip(1.0 - (within / (n - k)) / (total / (n - 1)), 0.0, 1.0))
