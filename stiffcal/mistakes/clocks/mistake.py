"""What a mistake in a clock is, and a way of taking it back."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.mistakes.deciding import schwarz
from stiffcal.mistakes.mistake import Mistake
from stiffcal.reduction.clocks.course import ClockCourse


@dataclass(frozen=True)
class ClockTrial:
    """The squares that the offsets of the pieces are left with, for how many numbers."""

    squares: float
    """In squared standard uncertainties of the pieces."""
    numbers: int
    """That were chosen by the offsets."""
    moves_s: float = 0.0
    """By how much the clock is off, or comes to be within the run, s."""
    sentence: str = ""
    """What is wrong and what to do."""

    def score(self, count: int) -> float:
        """Return Schwarz' criterion of so many pieces, whose noise is known."""
        return schwarz(self.squares, count, self.numbers, 1.0)


class ClockMistake(Mistake[ClockCourse, ClockTrial]):
    """One mistake in a clock, tried on how it runs against another in the pieces of a run."""
