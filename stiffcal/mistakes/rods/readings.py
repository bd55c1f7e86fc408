"""Readings of rods, and what of them contradicts the link's field or its load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.links.rods import RodDesign

# Of columns of unit length: a flexibility that no reading shows stays at zero.
RANK = 1e-9


@dataclass(frozen=True)
class RodReadings:
    """The rods' readings and what holds them together."""

    names: tuple[str, ...]
    """Of the m rods."""
    lengths: Floats
    """(n, m) m, less their run's mean."""
    sigma: float
    """m, one number, or 0 where not known."""
    time: Floats | None
    """(n,) s, or None."""
    run: Integers | None
    """(n,) or None."""
    columns: Floats | None
    """(p, n, m) what the rods read per unknown of the load model; None: the field alone."""
    design: RodDesign
    """Of the field."""
    used: Booleans
    """(m,) False for rods that were already found loose."""
    signed: bool = True
    """True where flexibilities cannot be negative."""
    growth: Floats | None = None
    """(n, m) m, what the rods would grow by the logged temperature if the link expanded by 1/K more than they, less its
    run's mean; None where no temperature changes.
    """

    def named(self, rods: Sequence[int]) -> str:
        """Return the names of some rods, in words."""
        return " and ".join(self.names[k] for k in rods)


def count_of(readings: RodReadings) -> int:
    """Return how many numbers hold the rods to each other."""
    n, rods = len(readings.lengths), readings.lengths.shape[1]
    held = rods if readings.columns is not None else max(rods - len(readings.design.carried), 1)
    return max(int(n * held), 2)


def squares_left(readings: RodReadings) -> tuple[float, int]:
    """Return the squared contradiction of the rods in use, and how many numbers the explanation took."""
    contradiction = left_over(readings, readings.lengths)[:, readings.used]
    offsets = 0 if readings.run is None else len(np.unique(readings.run)) * int(readings.used.sum())
    numbers = 0 if readings.columns is None else len(readings.columns)
    return float(np.sum(contradiction**2)), numbers + offsets


def centred_by_run(run: Integers | None, lengths: Floats) -> Floats:
    """Return (n, m) readings less their run's mean."""
    if run is None:
        return lengths
    result = lengths.copy()
    for number in np.unique(run):
        members = run == number
        result[members] -= result[members].mean(axis=0)
    return result


def left_over(readings: RodReadings, read: Floats) -> Floats:
    """Return (n, m) what the load model, or the field alone, leaves of readings; all rods, fitted to those in use."""
    used = readings.used
    if readings.columns is None:
        matrix = readings.design.matrix
        return np.asarray(read - read[:, used] @ np.linalg.pinv(matrix[used]).T @ matrix.T)
    columns = readings.columns
    rows = columns[:, :, used].reshape(len(columns), -1).T
    size = np.linalg.norm(rows, axis=0)
    size[size == 0.0] = 1.0
    flexible = np.linalg.lstsq(rows / size, read[:, used].ravel(), rcond=RANK)[0] / size
    # A link does not bend against its load: that is a sign, not a flexibility.
    if readings.signed:
        flexible[[0, 1, 3, 4]] = np.maximum(flexible[[0, 1, 3, 4]], 0.0)
    return np.asarray(read - np.einsum("p,pnm->nm", flexible, columns))
