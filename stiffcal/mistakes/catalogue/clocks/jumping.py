"""A clock that was set in the middle of a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.clocks.mistake import ClockMistake, ClockTrial
from stiffcal.reduction.clocks.course import ClockCourse
from stiffcal.wording import fixed_places


class JumpingClock(ClockMistake):
    """One offset up to a piece of the run, and another one from there on."""

    name = "jumping"
    rank = 12

    def ways(self, course: ClockCourse) -> Iterator[ClockTrial]:
        """Yield a step before each piece: its size and its place are chosen, and the offset."""
        for k in range(1, course.time.size):
            parts = slice(k), slice(k, None)
            before, after = (np.average(course.offset[part], weights=course.weight[part]) for part in parts)
            left, step = sum(course.misfit(course.offset, part) for part in parts), float(after - before)
            first, last = (fixed_places(course.time[at], 1) for at in (k - 1, k))
            when = f"at {first} s" if first == last else f"between {first} s and {last} s"
            sentence = (
                f"the clock of {course.source} jumps by {step:+.3f} s against {course.against} {when}; one offset is "
                "used for the whole run: correct the times in a copy of the log, or split the run there"
            )
            yield ClockTrial(left, 3, step, sentence)
