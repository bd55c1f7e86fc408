"""A clock that was wrong for a while: a mistake in clocks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.clocks.mistake import ClockMistake, ClockTrial
from stiffcal.reduction.clocks.course import ClockCourse


class HurriedPiece(ClockMistake):
    """One piece of a run with an offset of its own."""

    name = "hurried-piece"
    rank = 5

    def ways(self, course: ClockCourse) -> Iterator[ClockTrial]:
        """Yield the offsets without each piece."""
        for k in range(course.time.size):
            others = np.delete(np.arange(course.time.size), k)
            weight, left = course.weight[others], course.offset[others]
            mean = np.average(left, weights=weight)
            words = f"the clock of {course.source} was wrong about {course.time[k]:.3g} s"
            yield ClockTrial(float(weight @ (left - mean) ** 2), 3, float(course.offset[k] - mean), words)
