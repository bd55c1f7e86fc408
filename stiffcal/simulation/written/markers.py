"""Markers of an optical system that the robot hides from it at times."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats


def draw_hidden_markers(
    probability: float, n_markers: int, n_holds: int, rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Draw (n_holds, n_markers) which markers are hidden in which hold.

    A marker is lost for a whole hold, not for single readings: the arm does not move in it.

    Parameters
    ----------
    probability : that a marker is hidden in a hold, for all alike.
    n_markers, n_holds : how many there are.
    rng : draws them.
    """
    return np.asarray(rng.uniform(size=(n_holds, n_markers)) < probability)


def without_hidden(value: Floats, hidden: NDArray[np.bool_], hold: NDArray[np.int64]) -> Floats:
    """Return markers' places (n, 3 m) with those of hidden ones missing (NaN).

    Parameters
    ----------
    hidden : (n_holds, m).
    hold : (n,) the hold that each reading belongs to.
    """
    return np.where(np.repeat(hidden[hold], 3, axis=1), np.nan, value)
