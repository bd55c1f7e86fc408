"""How well the scale of the noise is known, and the density of residuals with that scale integrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class NoiseScale:
    """How well the rows' scale is known."""

    dof: float
    """Of the readings, what every hypothesis has taken out."""
    known: float
    """Degrees of freedom about the stated scale; 0: it is not known, infinite: exactly."""

    def log_density(self, square: Floats) -> Floats:
        """Return the log density of residuals of these sums of squares, constants left out."""
        square = np.maximum(square, 1e-300)
        if self.known == 0.0:
            return np.asarray(-0.5 * self.dof * np.log(square))
        if np.isinf(self.known):
            return np.asarray(-0.5 * square)
        return np.asarray(-0.5 * (self.dof + self.known) * np.log1p(square / self.known))

    def scale(self, square: Floats) -> Floats:
        """Return the noise's scale that residuals of these sums of squares show, in units of the rows."""
        if np.isinf(self.known):
            return np.ones_like(square)
        return np.asarray(np.sqrt((square + self.known) / (self.dof + self.known)))
