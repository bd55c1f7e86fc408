"""Designs that bear the loss of any one run: no wanted variance rests on a single run more than it has to."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.planning.criterion import LEAST_GAIN, Criterion, inverse, losses_after
from stiffcal.planning.repeats import Repeats

# An interval that one lost run makes so many times wider rests on it.
MUCH_WIDER = 1.25
# So much larger may the largest standard uncertainty with all runs become for it: 5 % in variance.
PRICE = np.log(1.025)
# Candidates that are tried in place of a run: the best without regard to losses.
TRIED = 30
MOST_PASSES = 2


def bearing_losses(factors: Floats, chosen: Integers, start: Floats, rows: Floats, most: Repeats) -> Integers:
    """Return a design whose largest standard uncertainty stays small with any one of its runs lost.

    Minimised by exchange is the larger of two: the largest standard uncertainty with all runs, and the largest with one
    run lost over `MUCH_WIDER`; the first may grow by `PRICE`.

    Parameters
    ----------
    factors : (N, r, p) of the candidates.
    chosen : (n,) the design to begin with.
    start : (p, p) information that there is already.
    rows : (q, p) what is wanted.
    most : how often candidates that are alike may be measured.
    """
    design = chosen.copy()
    if len(design) < 2:
        return design
    matrices = np.swapaxes(factors, 1, 2) @ factors
    most_with_all = _worst(start + matrices[design].sum(axis=0), rows) + PRICE
    loss = _loss(start, matrices[design], rows)
    for _ in range(MOST_PASSES):
        changed = False
        for place in range(len(design)):
            others = np.delete(design, place)
            without = start + matrices[others].sum(axis=0)
            plain = losses_after(factors, inverse(without), Criterion.WORST, rows)
            plain[most.exhausted(others, len(factors)) | (plain > most_with_all)] = np.inf
            tried = np.argsort(plain, kind="stable")[:TRIED]
            losses = np.maximum(plain[tried], _worst(without, rows) - np.log(MUCH_WIDER))
            for lost in np.unique(others):
                after = losses_after(factors[tried], inverse(without - matrices[lost]), Criterion.WORST, rows)
                losses = np.maximum(losses, after - np.log(MUCH_WIDER))
            best = int(np.argmin(losses))
            if losses[best] < loss - LEAST_GAIN:
                design[place], loss, changed = tried[best], float(losses[best]), True
        if not changed:
            break
    return design


def _loss(start: Floats, matrices: Floats, rows: Floats) -> float:
    whole = start + matrices.sum(axis=0)
    lost = max(_worst(whole - matrix, rows) for matrix in matrices)
    return max(_worst(whole, rows), lost - float(np.log(MUCH_WIDER)))


def _worst(matrix: Floats, rows: Floats) -> float:
    """Return the logarithm of the largest standard uncertainty, with the same small part of the mean as exchanges."""
    variances = np.sum((rows @ inverse(matrix)) * rows, axis=1)
    return float(0.5 * np.log(variances.max()) + 1e-6 * variances.mean() / variances.max())
