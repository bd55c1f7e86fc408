"""What a mistake in a clock is, and its trial on how the clock runs against another."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stiffcal.mistakes.deciding import schwarz
from stiffcal.reduction.clocks.course import ClockCourse


@dataclass(frozen=True)
class ClockTrial:
    """One mistake, taken back: the squares that the offsets of the pieces are left with, for how many numbers."""

    mistake: ClockMistake | None
    """None: the clock as it is taken."""
    squares: float
    """In squared standard uncertainties of the pieces."""
    numbers: int
    """That were chosen by the offsets."""
    moves_s: float = 0.0
    """By how much the clock is off, or comes to be within the run, s."""
    place: int = 0
    """The first piece that has it."""

    def score(self, count: int) -> float:
        """Return Schwarz' criterion of so many pieces, whose noise is known."""
        return schwarz(self.squares, count, self.numbers, 1.0)


class ClockMistake(ABC):
    """One mistake in a clock; a subclass in a file of `catalogue/` is found and tried."""

    name: ClassVar[str]
    """Its own."""
    rank: ClassVar[int] = 100
    """Of mistakes that explain a clock alike the one with the smaller number is named."""

    @abstractmethod
    def trials(self, course: ClockCourse) -> Iterator[ClockTrial]:
        """Yield the course with the mistake taken back, in each way in which it may be there."""

    @abstractmethod
    def sentence(self, course: ClockCourse, trial: ClockTrial) -> str:
        """Return what is wrong and what to do."""
