"""A clock whose offset is another one than the manifest states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.escapes import toml_text
from stiffcal.mistakes.clocks.mistake import ClockMistake, ClockTrial
from stiffcal.reduction.clocks.course import ClockCourse
from stiffcal.uncertainty import NORMAL_95


class ShiftedClock(ClockMistake):
    """The same offset in the whole run, and not the stated one."""

    name = "shifted"
    rank = 10

    def ways(self, course: ClockCourse) -> Iterator[ClockTrial]:
        """Yield it, where the manifest states an offset."""
        if course.stated is None:
            return
        found = float(np.average(course.offset, weights=course.weight))
        spread = NORMAL_95 / float(np.sqrt(course.weight.sum()))
        sentence = (
            f"clock_ahead_s of {course.source} is {course.stated:.3f} s, and its readings follow those of "
            f"{course.against} at {found:.3f} ± {spread:.3f} s: write "
            f"{toml_text.pair('clock_ahead_s', {course.source: round(found, 3)})}, or leave it out to have it estimated"
        )
        yield ClockTrial(course.misfit(course.offset), 1, found - course.stated, sentence)
