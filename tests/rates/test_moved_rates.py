"""The moves that the rates are counted of are as large as stated, and nothing is found where nothing moved."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.mistakes.places.steps import Steps
from tests.rates.moved_base import drawn, line_of


def test_the_gain_at_the_true_row_is_the_square_of_the_stated_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Noncentral χ² with six degrees of freedom: mean size² + 6, variance 2 (6 + 2 size²)."""
    gains: list[Floats] = []
    gains_of = Steps.gains

    def recorded(steps: Steps, left: Floats) -> tuple[Floats, Floats]:
        found = gains_of(steps, left)
        gains.append(found[0][:, 0])
        return found

    monkeypatch.setattr(Steps, "gains", recorded)
    at_row, found = [], []
    for k in range(20):
        gains.clear()
        row, move = drawn(1, 10.0, np.random.default_rng([1, k]))
        at_row.append(float(gains[0][row]))
        found.append((row, move))
    # at most one of twenty where 0.99 are found (binomial, 98 %)
    assert sum(move is not None for _, move in found) >= 18
    assert np.mean(at_row) == pytest.approx(106.0, abs=4.0 * np.sqrt(2.0 * 206.0 / 20))
    assert "exact" in line_of(10.0, found)


def test_nothing_is_found_where_nothing_moved() -> None:
    draws = [drawn(1, 0.0, np.random.default_rng([2, k])) for k in range(20)]
    # at 1 % two of twenty have a probability of 2 %
    assert sum(move is not None for _, move in draws) <= 2
    assert line_of(0.0, draws).startswith("   0  named 0.")
