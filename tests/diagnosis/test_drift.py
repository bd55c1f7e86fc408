"""Whether residuals of load states and of absolute places wander."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stiffcal.diagnosis.scans.drift import Drift, drift_of_states
from stiffcal.identification.readings.observations import Observations

N = 200


def found(absolute: bool, step: float) -> Drift:
    """Return the drift of noise and of a random walk with steps of so many noises; a run of 20, or a place each."""
    rng = np.random.default_rng(3)
    white = rng.normal(size=(3, N)) + step * np.cumsum(rng.normal(size=(3, N)), axis=1)
    run = np.arange(N) if absolute else np.arange(N) // 20
    data = SimpleNamespace(
        run=run, absolute=np.full(N, absolute), carries_offset=np.full(N, not absolute), free_offset=not absolute,
        measured_mask=np.ones((3, N), dtype=np.bool_),
    )  # fmt: skip
    # 40 values are estimated from absolute places, which takes from squares and differences alike
    left = np.sqrt(1.0 - 40.0 / (3 * N)) if absolute else 1.0
    return drift_of_states(cast("Observations", data), left * white, float(3 * N - 40))


@pytest.mark.parametrize("absolute", [False, True])
def test_noise_does_not_drift_and_a_walk_does(absolute: bool) -> None:
    assert not found(absolute, 0.0).drifts
    assert found(absolute, 0.4).drifts


def test_what_is_estimated_from_places_is_no_drift() -> None:
    assert found(True, 0.0).ratio == pytest.approx(1.0, abs=0.02)
