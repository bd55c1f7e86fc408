"""Integral deformation sensors: rods along a link that read by how much the distance of two of its points changes.

Beam frame: origin at the link's inboard, clamped end, x1 along the link to its outboard end, x3 the inboard joint's
axis made perpendicular to x1, x2 = x3 × x1 (physics, section 6).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats


@dataclass(frozen=True)
class Rods:
    """The m rods on one link."""

    link: str
    """The link's name."""
    names: tuple[str, ...]
    """m names, as in the manifest."""
    start: Floats
    """(m, 3) m, the material point where each rod begins, beam frame."""
    end: Floats
    """(m, 3) m, the material point where it ends, beam frame."""
    warping: Floats
    """(m, 2) value of the warping function at start and end, m²; NaN where not known."""
    sigma: Floats
    """(m,) standard uncertainty of one state's reading, m; NaN where not known."""
    growth: Floats = field(default_factory=lambda: np.zeros(0))
    """(m,) by how much more the link grows along a rod than the rod itself as both get warmer, m/K; NaN, or no numbers
    at all, where not known.
    """

    @property
    def length(self) -> Floats:
        """(m,) how long the rods are, m."""
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))

    def pick(self, keep: NDArray[np.bool_] | NDArray[np.int64] | list[int]) -> Rods:
        """Return some of the rods, by mask or indices."""
        index = np.arange(len(self.names))[keep]
        return Rods(
            self.link,
            tuple(self.names[i] for i in index),
            self.start[index],
            self.end[index],
            self.warping[index],
            self.sigma[index],
            self.growth[index] if len(self.growth) else self.growth,
        )


def rods_between(
    link: str, start: Floats, end: Floats, sigma: float = np.nan, names: tuple[str, ...] | None = None
) -> Rods:
    """Return rods of which only the ends are known.

    Examples
    --------
    >>> rods = rods_between("swing", np.zeros((2, 3)), np.array([[0.8, 0.0, 0.0], [0.5, 0.0, 0.0]]))
    >>> rods.names, rods.length.tolist()
    (('ids1', 'ids2'), [0.8, 0.5])
    """
    start, end = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    count = len(start)
    names = names or tuple(f"ids{i + 1}" for i in range(count))
    return Rods(link, names, start, end, np.full((count, 2), np.nan), np.full(count, sigma))


@dataclass(frozen=True)
class BeamProperties:
    """What the displacement field of a link needs to know of it."""

    length: float
    """m."""
    neutral: tuple[float, float] = (0.0, 0.0)
    """(x2, x3) of the neutral fibre, m: where tension does not bend and bending does not stretch."""
    twist_centre: tuple[float, float] = (0.0, 0.0)
    """(x2, x3) of the fibre that torsion leaves straight, m (the section's shear centre)."""
    warping_decay: float | None = None
    """m, length over which warping held back at the clamp decays; None where not known: the twist is then taken as even
    along the link (000: κ constant), and a rod parallel to the link does not measure it.
    """
    warping_hold: float = 1.0
    """Share of the twist that the clamp takes away there; 1 for open sections (Vlasov), less for closed ones, where the
    section shears as well.
    """
