"""Clocks, frames and sensors zeroed anew: an iteration that misses its convergence test claims nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.measurements.varying import varies
from stiffcal.model.laws import cubic_curve
from stiffcal.model.laws.cubic_curve import angle_of_torque, monotonic_range
from stiffcal.reduction.clocks import offsets as clocks
from stiffcal.reduction.clocks.lag_search import SharedSignal
from stiffcal.reduction.loads.cycles import load_vector


def logs(lag: float) -> tuple[SharedSignal, SharedSignal]:
    """Return a load that goes up and down in steps, and a position that follows it on another clock."""
    time = np.arange(0.0, 60.0, 0.01)
    load = 100.0 * np.clip(np.abs((time % 12.0) - 6.0) - 2.0, 0.0, 2.0)
    rng = np.random.default_rng(1)
    force = SharedSignal("ft", time, load[:, None] + rng.normal(0.0, 0.5, (time.size, 1)), True)
    place = SharedSignal("tracker", time + lag, 1e-6 * load[:, None] + rng.normal(0.0, 1e-6, (time.size, 1)), False)
    return force, place


def test_a_lag_that_does_not_settle_is_no_lag(monkeypatch: pytest.MonkeyPatch) -> None:
    force, place = logs(0.2)
    found = clocks._refine_lag(force, place, 0.21)
    assert found.value == pytest.approx(0.2, abs=5e-3)
    answers = iter(np.tile([0.05, -0.05], 100))

    def restless(*_: Any) -> tuple[Any, Any]:
        return np.full(8, next(answers)), np.full(8, 1e8)

    monkeypatch.setattr(clocks, "ramp_answers", restless)
    lost = clocks._refine_lag(force, place, 0.21)
    assert lost.value is None
    assert "does not converge" in lost.reason


def test_springs_angles_are_found_to_rounding() -> None:
    curve = (1.3e5, -4.0e7, 9.0e9)
    torque = np.linspace(-400.0, 400.0, 41)
    angle = angle_of_torque(torque, curve)
    low, high = monotonic_range(curve)
    assert low < angle.min() < angle.max() < high
    assert np.abs(np.polyval([*curve[::-1], 0.0], angle) - torque).max() <= 1e-10
    assert np.isnan(angle_of_torque(np.array([1.0, np.inf]), curve)).all()


def test_springs_angles_that_do_not_settle_are_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cubic_curve, "_MOST_STEPS", 1)
    with pytest.raises(ArithmeticError, match="no angle of the spring exists"):
        angle_of_torque(np.linspace(-400.0, 400.0, 41), (1.3e5, -4.0e7, 9.0e9))


def test_averages_of_a_constant_do_not_vary() -> None:
    means = np.array([np.full(k, 21.3).mean() for k in range(1, 2000)]) + 273.15
    assert not varies(means)
    assert varies(means + np.linspace(0.0, 1e-6, means.size))


def test_forces_that_are_rounding_are_no_load() -> None:
    """Moments alone were applied; turned into other axes forces of 1e-17 N are nothing."""
    wrench = np.zeros((4, 6))
    wrench[:, 5] = [0.0, 50.0, 100.0, 50.0]
    for rounding in (0.0, 1e-17):
        wrench[:, 0] = rounding
        assert load_vector(wrench)[:, 2].tolist() == [0.0, 50.0, 100.0, 50.0]
