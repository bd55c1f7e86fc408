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

    def trials(self, course: ClockCourse) -> Iterator[ClockTrial]:
        """Yield a step before each piece: its size and its place are chosen, and the offset."""
        for k in range(1, course.time.size):
            parts = slice(k), slice(k, None)
            before, after = (np.average(course.offset[part], weights=course.weight[part]) for part in parts)
            left = sum(course.misfit(course.offset, part) for part in parts)
            yield ClockTrial(self, left, 3, float(after - before), k)

    def sentence(self, course: ClockCourse, trial: ClockTrial) -> str:
        """Return it in words."""
        before, after = (fixed_places(course.time[k], 1) for k in (trial.place - 1, trial.place))
        when = f"at {before} s" if before == after else f"between {before} s and {after} s"
        return (
            f"the clock of {course.source} jumps by {trial.moves_s:+.3f} s against {course.against} "
            f"{when}; one offset is used for the whole run: correct the times in a copy of "
            "the log, or split the run there"
        )
