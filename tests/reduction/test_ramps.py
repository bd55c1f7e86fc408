"""What the ramps of a load tell of a clock, all at once and one after the other."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.reduction.clocks.ramps import Integral, ramp_answers


def one_by_one(
    windows: list[tuple[float, float, float]],
    load: tuple[Floats, Floats],
    seen: tuple[Floats, Floats],
    lag: float,
    scale: float,
) -> tuple[Floats, Floats]:
    """Return the corrections and weights by a regression of each ramp's readings on a level and the load's course."""
    time, white = seen
    fine = np.linspace(-0.5, 0.5, 4001)
    steps, weights = [], []
    for begin, end, _ in windows:
        at = time[(time >= begin + lag) & (time < end + lag)] - lag

        def running(shift: float, width: float, at: Floats = at) -> Floats:
            moments = at[:, None] + shift + width * fine
            return np.stack([np.interp(moments, load[0], column).mean(axis=1) for column in load[1].T], axis=1)

        course = running(0.0, scale)
        sixth = len(course) // 6
        direction = course[-sixth:].mean(axis=0) - course[:sixth].mean(axis=0)
        direction = direction / (direction @ direction)
        slope = (running(0.25 * scale, 0.5 * scale) - running(-0.25 * scale, 0.5 * scale)) @ direction / (0.5 * scale)
        design = np.stack([np.ones(len(at)), course @ direction], axis=1)
        readings = white[(time >= begin + lag) & (time < end + lag)]
        gain = np.linalg.lstsq(design, readings, rcond=None)[0][1]
        residual = readings - design @ np.linalg.lstsq(design, readings, rcond=None)[0]
        moved = slope - design @ np.linalg.lstsq(design, slope, rcond=None)[0]
        weights.append(float((gain @ gain) * (moved @ moved)))
        steps.append(-float(moved @ (residual @ gain)) / weights[-1])
    return np.array(steps), np.array(weights)


def test_all_ramps_at_once_are_each_by_itself() -> None:
    """Three ramps of different length; a window without a ramp and one without readings say nothing."""
    rng = np.random.default_rng(5)
    time = np.arange(0.0, 60.0, 0.02)
    course = np.interp(time, [5.0, 7.0, 20.0, 21.0, 40.0, 43.0], [0.0, 60.0, 60.0, 10.0, 10.0, 90.0])
    load = np.stack([course, -0.3 * course], axis=1) + 0.1 * rng.normal(size=(len(time), 2))
    slow = np.arange(0.5, 59.0, 0.05)
    late = np.interp(slow - 0.25, time, course)
    seen = np.stack([0.2 * late, -0.1 * late, 0.0 * late], axis=1) + 0.1 * rng.normal(size=(len(slow), 3))
    ramps = [(3.0, 9.0, 2.0), (18.5, 22.5, 1.0), (37.0, 46.0, 3.0)]
    steps, weights = ramp_answers(
        [ramps[0], (25.0, 30.0, 1.0), *ramps[1:], (300.0, 310.0, 1.0)], Integral(time, load), slow, seen, 0.2, 0.4
    )
    expected, expected_weights = one_by_one(ramps, (time, load), (slow, seen), 0.2, 0.4)
    # the reference takes its means from 4001 points, which is good to a thousandth
    assert steps == pytest.approx(expected, rel=5e-3, abs=2e-4)
    assert weights == pytest.approx(expected_weights, rel=5e-3)
    assert np.average(steps, weights=weights) == pytest.approx(0.05, abs=0.02)
