"""Clocks that are not in order: the mistake in each that explains how it runs against another."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mistakes.clocks.mistake import ClockMistake, ClockTrial
from stiffcal.mistakes.deciding import DECISIVE
from stiffcal.mistakes.found import ways_of
from stiffcal.mistakes.mistake import Mistake
from stiffcal.reduction.clocks.course import ClockCourse

# Holds are read from a few hundredths of their second after the ramp: less than this moves no reading out of its hold.
MATTERS_S = 0.03


def clock_warnings(run: str, courses: Sequence[ClockCourse]) -> list[str]:
    """Return a line for every clock of a run that has a mistake which matters to its holds.

    Parameters
    ----------
    run : its name. courses : of each clock that can be compared.
    """
    found = map(clock_mistake, courses)
    return [f"run {run}: {one[1].sentence}" for one in found if one is not None]


def clock_mistake(course: ClockCourse) -> tuple[Mistake[ClockCourse, ClockTrial], ClockTrial] | None:
    """Return the mistake that explains a course decisively better than none, and moves readings out of their holds."""
    count, as_taken = len(course.offset), _as_taken(course)
    mistake, best = min([(None, as_taken), *ways_of(ClockMistake, course)], key=lambda one: one[1].score(count))
    decides = abs(best.moves_s) > MATTERS_S and as_taken.score(count) - best.score(count) >= DECISIVE
    return (mistake, best) if mistake is not None and decides else None


def _as_taken(course: ClockCourse) -> ClockTrial:
    """Return what one offset leaves: the stated one, or that of the run, which is chosen."""
    if course.stated is None:
        return ClockTrial(course.misfit(course.offset), 1)
    return ClockTrial(float(course.weight @ (course.offset - course.stated) ** 2), 0)
