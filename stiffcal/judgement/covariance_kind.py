"""What a judgement asks of a way in which readings err together: their covariance V at each of several sizes."""

from __future__ import annotations

from typing import Protocol

from stiffcal.arrays import Floats


class CovarianceKind(Protocol):
    """A way in which readings err together: V⁻¹ = I − U w Uᵀ, with orthonormal directions U (r, d) of whitened rows."""

    @property
    def sizes(self) -> Floats:
        """(s,) grid of its size."""

    def weights(self, size: float) -> Floats:
        """Return w (d,) at a size: 1 − 1 / the variance along each direction."""

    def log_determinant(self, size: float) -> float:
        """Return log |V|."""

    def along(self, rows: Floats) -> Floats:
        """Return (k, d) the parts of whitened rows (k, r) along the directions."""

    def taken_out(self, rows: Floats, weights: Floats, found: Floats | None = None) -> Floats:
        """Return V⁻¹ times whitened rows (k, r), of weights (d,); as of `Discrepancy.taken_out`."""

    def leverage(self, weights: Floats) -> Floats:
        """Return (r,) the share of each row that lies along the directions, times weights (d,)."""

    def variance_of_noise(self, weights: Floats) -> Floats:
        """Return (r,) the variance of each row's noise next to all else that is read."""
