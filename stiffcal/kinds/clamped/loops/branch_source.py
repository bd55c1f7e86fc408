"""Averaged branches of a clamped joint as rows of a fit, for any way to write the law with p numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.rows import Rows
from stiffcal.estimation.triangular import Reduced
from stiffcal.estimation.unknowns import Unknowns
from stiffcal.kinds.clamped.loops.branches import Branches
from stiffcal.kinds.clamped.loops.torque_angle import TorqueAngleLaw

# A misfit below this share of the largest torque is rounding.
LEAST_MISFIT = 1e-9


@dataclass(frozen=True)
class BinNoise:
    """Misfit of the bins, alike for all of them (`stiffcal.estimation.rows.RowSpace`)."""

    sigma: float
    """N·m, or in the unit of the branches' torque."""
    n_constants: int = 0
    """None is free."""

    def rows(self, stack: Floats) -> Floats:
        """Return (q, m) rows of unit variance of (q, 1, m)."""
        return np.asarray(stack[:, 0] / self.sigma)

    def sums_as(self, other: BinNoise) -> bool:
        """Return whether a sum of squares compares with that under others."""
        return self.sigma == other.sigma


@dataclass(frozen=True)
class BranchSource:
    """Makes rows of averaged branches (`stiffcal.estimation.solve.RowSource`)."""

    data: Branches
    """The m bins."""
    unknowns: Unknowns
    """The p numbers."""
    law_at: Callable[[Floats], TorqueAngleLaw]
    """Returns the law at values (p,)."""
    slopes_at: Callable[[Floats], Floats]
    """Returns (m, p) the derivative of the torque."""

    curved = True
    lasting_weights = False

    def about(self, values: Floats, space: BinNoise) -> Rows:
        """Return the rows about values (p,)."""
        torque = self.law_at(values).torque_at(self.data.angle, self.data.up)
        return Rows(
            self.unknowns, values, self.slopes_at(values).T[:, None], torque[None], self.data.torque[None],
            np.ones((1, len(torque)), dtype=np.bool_), space, np.zeros((0, len(values) + 1)),
        )  # fmt: skip

    def misfit(self, values: Floats) -> float:
        """Return the rms misfit at values (p,) per degree of freedom, in the unit of the torque."""
        left = self.data.torque - self.law_at(values).torque_at(self.data.angle, self.data.up)
        return float(np.sqrt(np.sum(left**2) / max(len(left) - len(values), 1)))

    def reduced(self, values: Floats, weights: BinNoise | None, renew: bool) -> tuple[Reduced, BinNoise]:
        """Return the rows about values (p,), and their weights; see `stiffcal.estimation.solve.RowSource`."""
        if weights is None or renew:
            least = LEAST_MISFIT * float(np.abs(self.data.torque).max(initial=0.0))
            weights = BinNoise(max(self.misfit(values), least, 1e-300))
        return self.about(values, weights).reduced(), weights

    def squares(self, values: Floats, reduced: Reduced, weights: BinNoise) -> float:
        """Return the sum of squares of the rows about values (p,) under other weights."""
        return float(np.sum(self.about(values, weights).white[-1] ** 2))

    def corrected(self, values: Floats, reduced: Reduced, weights: BinNoise) -> tuple[BranchSource, float]:
        """Return the source: its readings are not corrected."""
        return self, 0.0
