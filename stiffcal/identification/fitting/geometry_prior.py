"""How well the robot's geometry is known, and what that is from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.geometry_source import GeometrySource

# Places that miss by so many times the usual tolerance (1.5 mm per length, 0.06° per angle) are of no robot as built …
GEOMETRY_WRONG = 3.0
# … and where the links' masses are not known, what the robot sags under its weight is in the misfit too.
GEOMETRY_WRONG_WITHOUT_MASSES = 6.0


@dataclass(frozen=True)
class GeometryPrior:
    """How well the robot's lengths and angles are known."""

    length: float
    """m, standard deviation of every length."""
    angle: float
    """rad, of every angle."""
    source: GeometrySource
    """What it is from."""
    misfit: float | None = None
    """How many times the tolerance of the robot file (or the default) absolute places miss by; None where unknown."""

    def contradicted(self, masses_known: bool) -> bool:
        """Return whether absolute places contradict the robot file."""
        most = GEOMETRY_WRONG if masses_known else GEOMETRY_WRONG_WITHOUT_MASSES
        return self.misfit is not None and self.misfit >= most

    def sizes(self, n_joints: int) -> Floats:
        """Return (6J,) standard deviations in the order of `geometry_changes`."""
        return np.tile(np.repeat([self.length, self.angle], 3), n_joints)
