"""tracker-frame: D_seen = exp(r) D, base axes."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.tracker_frame import TrackerFrame
from stiffcal.model.effect import Observed, Place
from tests.laboratory.effect_bench import order_of

EFFECT = TrackerFrame()
PLACE = Place("setup")


def observed(rng: np.random.Generator) -> Observed:
    return Observed(rng.normal(0.0, 1e-3, (2, 6, 4)), order_of([0] * 4))


def test_a_quarter_turn_about_z() -> None:
    seen = Observed(np.arange(6.0)[None, :, None], order_of([0]))
    shift = EFFECT.observation_shift(PLACE, seen, {"rz": np.pi / 2})
    np.testing.assert_allclose((seen.displacement + shift)[0, :, 0], [-1.0, 0.0, 2.0, -4.0, 3.0, 5.0], atol=1e-15)


def test_lengths_stay() -> None:
    seen = observed(np.random.default_rng(10))
    turned = seen.displacement + EFFECT.observation_shift(PLACE, seen, {"rx": 0.2, "ry": -0.1, "rz": 0.4})
    for part in (slice(0, 3), slice(3, 6)):
        np.testing.assert_allclose(
            np.linalg.norm(turned[:, part], axis=1), np.linalg.norm(seen.displacement[:, part], axis=1), rtol=1e-12
        )


def test_columns_are_the_slope_of_the_shift() -> None:
    seen = observed(np.random.default_rng(11))
    columns = EFFECT.observation_columns(PLACE, seen, {})
    for symbol in ("rx", "ry", "rz"):
        step = 1e-6
        slope = (
            EFFECT.observation_shift(PLACE, seen, {symbol: step})
            - EFFECT.observation_shift(PLACE, seen, {symbol: -step})
        ) / (2 * step)
        np.testing.assert_allclose(columns[symbol], slope, atol=1e-12)
