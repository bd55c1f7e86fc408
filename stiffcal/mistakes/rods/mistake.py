"""What a mistake in rods is, and a way of taking it back."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.mistakes.deciding import schwarz
from stiffcal.mistakes.mistake import Mistake
from stiffcal.mistakes.rods.readings import RodReadings

# m²: a tenth of a nanometre per rod, below what any gauge reads and above rounding.
LEAST_MEAN_SQUARE = 1e-22


@dataclass(frozen=True)
class RodTrial:
    """The readings with one mistake taken back, the squared contradiction left, how many numbers that took."""

    rods: tuple[int, ...]
    """Those that have it."""
    mended: RodReadings
    """Without it."""
    squares: float
    """m², of what contradicts."""
    numbers: int
    """That were chosen by the readings."""
    size: float = 0.0
    """m, rms of what is wrong with these rods' readings."""
    words: str = ""
    """What is wrong."""
    mend: str = ""
    """What to do."""
    reads_right: bool = False
    """Whether the rods read just what they should, in another sign or column: then they are not loose."""
    leaves_out: bool = False
    """Whether the rod's readings are left out, so that whatever is wrong with it is explained."""
    grows_slowly: bool = False
    """Whether it makes repeats a cycle apart differ: noise that is known from these is no proof against it."""

    def score(self, count: int, sigma: float) -> float:
        """Return Schwarz' criterion of ``count`` readings; noise is the least that can be left."""
        return schwarz(self.squares, count, self.numbers, max(sigma**2, LEAST_MEAN_SQUARE))


class RodMistake(Mistake[RodReadings, RodTrial]):
    """One mistake in rods, at each rod, or pair of rods, that may have it; `name` is the fault's kind."""
