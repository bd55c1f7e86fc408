"""A clock that runs faster or slower than another."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.clocks.mistake import ClockMistake, ClockTrial
from stiffcal.reduction.clocks.course import ClockCourse
from stiffcal.uncertainty import NORMAL_95


class DriftingClock(ClockMistake):
    """An offset that grows with time."""

    name = "drifting"
    rank = 11

    def trials(self, course: ClockCourse) -> Iterator[ClockTrial]:
        """Yield the offsets less a straight line."""
        left = course.misfit(course.offset - course.rate * course.time)
        yield ClockTrial(self, left, 2, course.rate * course.lasts)

    def sentence(self, course: ClockCourse, trial: ClockTrial) -> str:
        """Return it in words."""
        return (
            f"the clock of {course.source} gains {1e6 * course.rate:+.0f} ± "
            f"{1e6 * NORMAL_95 * course.rate_std:.0f} ppm on {course.against}, {1e3 * abs(trial.moves_s):.0f} ms over "
            "the run; one offset, that of its middle, is used: dwells shorter than that are misread; correct the times "
            "in a copy of the log, or split the run"
        )
