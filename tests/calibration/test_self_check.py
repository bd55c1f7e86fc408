"""Probabilities of problems that are drawn from the very priors are right."""

from __future__ import annotations

import pytest

from tests.calibration.self_check import EDGES, drawn_and_judged, worst

ERRORS = 4.0
"""Standard errors by which the worst of a dozen bins is off in fewer than one of a thousand right judges."""


@pytest.mark.long
def test_stated_probabilities_are_true() -> None:
    assert worst(drawn_and_judged(seed=2, count=150), EDGES) < ERRORS
