"""Clocks that are not in order: the mistake in each that explains how it runs against another."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mistakes.clocks.mistake import ClockMistake, ClockTrial
from stiffcal.mistakes.deciding import DECISIVE
from stiffcal.mistakes.found import mistakes_of
from stiffcal.reduction.clocks.course import ClockCourse

# Holds are read from a few hundredths of their second after the ramp: less than this moves no reading out of its hold.
MATTERS_S = 0.03


def clock_warnings(run: str, courses: Sequence[ClockCourse]) -> list[str]:
    """Return a line for every clock of a run that has a mistake which matters to its holds.

    Parameters
    ----------
    run : its name. courses : of each clock that can be compared.
    """
    found = ((course, clock_mistake(course)) for course in courses)
    return [f"run {run}: {one.mistake.sentence(course, one)}" for course, one in found if one and one.mistake]


def clock_mistake(course: ClockCourse) -> ClockTrial | None:
    """Return the mistake that explains a course decisively better than none, and moves readings out of their holds."""
    count, as_taken = len(course.offset), _as_taken(course)
    trials = [trial for mistake in mistakes_of(ClockMistake) for trial in mistake.trials(course)]
    best = min([as_taken, *trials], key=lambda trial: trial.score(count))
    matters = best.mistake is not None and abs(best.moves_s) > MATTERS_S
    return best if matters and as_taken.score(count) - best.score(count) >= DECISIVE else None


def _as_taken(course: ClockCourse) -> ClockTrial:
    """Return what one offset leaves: the stated one, or that of the run, which is chosen."""
    if course.stated is None:
        return ClockTrial(None, course.misfit(course.offset), 1)
    return ClockTrial(None, float(course.weight @ (course.offset - course.stated) ** 2), 0)
