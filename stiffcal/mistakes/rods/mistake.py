"""What a mistake in rods is, and its trial on their readings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from stiffcal.mistakes.deciding import schwarz
from stiffcal.mistakes.rods.readings import RodReadings

# m²: a tenth of a nanometre per rod, below what any gauge reads and above rounding.
LEAST_MEAN_SQUARE = 1e-22


@dataclass(frozen=True)
class RodTrial:
    """One mistake, taken back: the readings without it, the squared contradiction left, how many numbers that took."""

    mistake: RodMistake | None
    """None: the readings as they are."""
    rods: tuple[int, ...]
    mended: RodReadings
    squares: float
    numbers: int
    size: float

    def score(self, count: int, sigma: float) -> float:
        """Return Schwarz' criterion of ``count`` readings; noise is the least that can be left."""
        return schwarz(self.squares, count, self.numbers, max(sigma**2, LEAST_MEAN_SQUARE))


class RodMistake(ABC):
    """One mistake in rods; a subclass in a file of `stiffcal/mistakes/catalogue` is found and tried."""

    name: ClassVar[str]
    """The fault's kind."""
    rank: ClassVar[int] = 100
    """Of mistakes that explain the readings alike the one with the smaller number is named."""
    reads_right: ClassVar[bool] = False
    """Whether the rod reads just what it should, in another sign or column: then it is not loose."""
    leaves_out: ClassVar[bool] = False
    """Whether the rod's readings are left out, so that whatever is wrong with it is explained."""

    @abstractmethod
    def trials(self, readings: RodReadings) -> Iterator[RodTrial]:
        """Yield the readings with the mistake taken back, at each rod, or pair of rods, that may have it."""

    @abstractmethod
    def sentence(self, rods: Sequence[str], trial: RodTrial, rms: str) -> str:
        """Return what is wrong and what to do.

        Parameters
        ----------
        rods : names. trial : the mistake, taken back. rms : what that does to the contradiction, in words.
        """

    def is_large(self, trial: RodTrial, readings: RodReadings) -> bool:
        """Return whether it is large enough to be one."""
        return True

    def grows_slowly(self, trial: RodTrial, left_m: float) -> bool:
        """Return whether it makes repeats a cycle apart differ: noise that is known from these is no proof against it.

        Parameters
        ----------
        trial : the mistake, taken back. left_m : rms of the contradiction without it.
        """
        return False

    def size(self, trial: RodTrial, readings: RodReadings) -> float:
        """Return the rms of what is wrong with the rods' readings, m."""
        return trial.size
