"""Which mistake of a clock is named, by how it runs against another in the pieces of a run."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.mistakes.clocks.found import clock_mistake
from stiffcal.reduction.clocks.course import ClockCourse, clock_courses
from stiffcal.reduction.clocks.lag_search import SharedSignal
from stiffcal.reduction.clocks.offsets import align_clocks
from tests.laboratory.made_up_logs import load_cycle
from tests.reduction.test_clocks import tracker_of

PIECES = np.arange(6.0)


def course_of(offset: Floats, stated: float | None = None) -> ClockCourse:
    scatter = 0.002 * np.array([1.0, -1.0, 0.5, 1.0, -1.5, 0.0])
    return ClockCourse("tracker", "ft", 20.0 * PIECES, offset + scatter, np.full(6, 0.002), stated)


@pytest.mark.parametrize(
    ("offset", "stated", "named"),
    [
        (np.full(6, 0.4), None, ""),
        (np.full(6, 0.4), 0.4, ""),
        (np.full(6, 0.42), 0.4, ""),
        (np.full(6, 0.5), 0.4, "shifted"),
        (0.4 + 0.001 * 20.0 * PIECES, None, "drifting"),
        (0.4 + 0.001 * 20.0 * PIECES, 0.4, "drifting"),
        (0.4 + 0.0001 * 20.0 * PIECES, None, ""),
        (0.4 + 0.3 * (PIECES > 3), None, "jumping"),
        (0.4 + 0.3 * (PIECES > 3), 0.4, "jumping"),
    ],
)
def test_a_clock_is_named_by_what_explains_its_course(offset: Floats, stated: float | None, named: str) -> None:
    found = clock_mistake(course_of(offset, stated))
    assert ("" if found is None else found[0].name) == named


def test_a_stated_offset_that_the_logs_contradict_is_named() -> None:
    generator = np.random.default_rng(1)
    time, wrench, _ = load_cycle(generator)
    shared = [SharedSignal("ft", time, wrench, True), tracker_of(generator, time, wrench, 0.39)]
    for stated, off in ((0.25, True), (0.39, False)):
        given = {"tracker": stated}
        clocks, courses = clock_courses(shared, align_clocks(shared, given), given)
        assert clocks["tracker"].value == stated
        assert courses[0].offset.mean() == pytest.approx(0.39, abs=0.01)
        assert (clock_mistake(courses[0]) is not None) == off
