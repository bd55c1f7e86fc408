"""The choice among candidates, repeated without each group of poses."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.scan import ROUNDING, Scan


def first_least(errors: Floats) -> Integers:
    """Return (f,) which of errors (t, f) is least, the first of those that differ by rounding only."""
    least = errors.min(axis=0)
    return np.asarray(np.argmax(errors <= least + ROUNDING * np.abs(least), axis=0), dtype=np.int64)


def choice_without_each_group(scan: Scan) -> Integers:
    """Return (G,) which candidate the poses outside each group choose: 0 the present model, k the scan's trial k - 1.

    The present model takes part in the choice: where nothing helps, nothing is chosen.
    """
    scores = [scan.base, *(trial.score for trial in scan.trials)]
    return first_least(np.stack([score.nested.sum(axis=1) - np.diagonal(score.nested) for score in scores]))
