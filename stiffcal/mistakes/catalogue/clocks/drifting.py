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

    def ways(self, course: ClockCourse) -> Iterator[ClockTrial]:
        """Yield the offsets less a straight line."""
        gained = course.rate * course.lasts
        sentence = (
            f"the clock of {course.source} gains {1e6 * course.rate:+.0f} ± "
            f"{1e6 * NORMAL_95 * course.rate_std:.0f} ppm on {course.against}, {1e3 * abs(gained):.0f} ms over "
            "the run; one offset, that of its middle, is used: dwells shorter than that are misread; correct the times "
            "in a copy of the log, or split the run"
        )
        yield ClockTrial(course.misfit(course.offset - course.rate * course.time), 2, gained, sentence)
