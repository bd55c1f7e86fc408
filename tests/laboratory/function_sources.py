"""Readings that are functions of a few unknowns, as any kind of experiment would give them to the solver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.errors import no_progress
from stiffcal.estimation.groups import GroupNoise
from stiffcal.estimation.prior import Prior
from stiffcal.estimation.rows import Rows, RowSpace
from stiffcal.estimation.solve import Settled, settle
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.unknowns import Unknowns

Function = Callable[[Floats], Floats]


class Unchanging:
    """Weights that stay as they are."""

    def sums_as(self, other: Unchanging) -> bool:
        return True


def slopes(function: Function, values: Floats) -> Floats:
    """Return (p, …) central differences."""
    steps = 1e-6 * np.maximum(np.abs(values), 1e-6)
    one = np.eye(len(values))
    return np.stack(
        [
            (function(values + step * e) - function(values - step * e)) / (2 * step)
            for step, e in zip(steps, one, strict=True)
        ]
    )


@dataclass(frozen=True)
class FunctionSource:
    """Readings (m, n) that a function of p unknowns predicts."""

    unknowns: Unknowns
    function: Function
    measured: Floats
    space: RowSpace
    prior: Prior | None = None
    change: Callable[[Rows], Rows] | None = None
    """Turns the rows into others: equations of the readings."""
    curved: bool = True
    lasting_weights: bool = False

    def about(self, values: Floats) -> Rows:
        mask: Booleans = np.isfinite(self.measured)
        known = np.zeros((0, len(values) + 1)) if self.prior is None else self.prior.rows(values)
        rows = Rows(
            self.unknowns, values, slopes(self.function, values), self.function(values), self.measured, mask,
            self.space, known,
        )  # fmt: skip
        return rows if self.change is None else self.change(rows)

    def reduced(self, values: Floats, weights: Unchanging | None, renew: bool) -> tuple[Reduced, Unchanging]:
        return self.about(values).reduced(), Unchanging()

    def squares(self, values: Floats, reduced: Reduced, weights: Unchanging) -> float:
        return reduced.cost(np.zeros_like(values))

    def corrected(self, values: Floats, reduced: Reduced, weights: Unchanging) -> tuple[FunctionSource, float]:
        return self, 0.0


def solved(source: FunctionSource, start: Floats) -> Settled[Unchanging]:
    """Return where the solver ends."""
    return settle(source, start, None, no_progress)


def independent(sigma: float, shape: tuple[int, int]) -> GroupNoise:
    """Return the noise of readings that have nothing in common."""
    return GroupNoise.independent(np.full(shape, sigma), np.zeros(shape[1], dtype=np.int64))
