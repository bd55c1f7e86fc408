"""Minima of a loss over a lag: all of them, and whether the parts of a run distinguish two."""

from __future__ import annotations

import math

import pytest

from stiffcal.reduction.clocks.lag_minima import are_distinguished, lag_minima, nearest_minimum

SETTLED = 1e-6


def wells(lag: float) -> float:
    """Return a loss with a wide minimum at −0.3 s and a narrow, deeper one at 0.42 s."""
    return 1.0 - 0.5 * math.exp(-(((lag + 0.3) / 0.2) ** 2)) - 0.8 * math.exp(-(((lag - 0.42) / 0.03) ** 2))


def test_the_deepest_of_all_minima_comes_first() -> None:
    first, second, *_ = lag_minima(wells, -1.0, 1.0, 0.02, SETTLED)
    assert first.lag == pytest.approx(0.42, abs=2.0 * SETTLED)
    assert second.lag == pytest.approx(-0.3, abs=2.0 * SETTLED)
    assert first.inside
    assert second.inside


def test_a_loss_that_falls_to_the_end_of_the_range_has_no_minimum_inside() -> None:
    (only,) = lag_minima(lambda lag: -lag, 0.0, 1.0, 0.1, SETTLED)
    assert (only.lag, only.inside) == (1.0, False)


def test_the_nearest_minimum_is_downhill() -> None:
    found = nearest_minimum(wells, -0.1, 0.02, 0.5, SETTLED)
    assert found.lag == pytest.approx(-0.3, abs=2.0 * SETTLED)
    assert found.inside
    assert not nearest_minimum(lambda lag: lag, 0.0, 0.1, 0.5, SETTLED).inside


def test_parts_distinguish_lags() -> None:
    assert are_distinguished([1.0, 1.1, 0.9, 1.0], [1.5, 1.7, 1.5, 1.6])
    assert not are_distinguished([1.0, 1.1, 0.9, 1.0], [1.5, 0.7, 1.4, 0.6])
