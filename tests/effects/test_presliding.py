"""presliding: Dahl's solid friction after a reversal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stiffcal.effects.presliding import Presliding
from tests.laboratory.drive_motions import strokes
from tests.laboratory.effect_bench import robot_chain

EFFECT, CHAIN = Presliding(), robot_chain()
PLACE = EFFECT.places(CHAIN)[1]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_law_is_dahls(direction: float) -> None:
    """Against an integration of dF/ds = σ (1 − F/F_C sign ω), from full friction the other way (Dahl 1968)."""
    coulomb, sigma = 40.0, 2e4
    path = np.linspace(0.0, 0.02, 81)
    dahl = solve_ivp(
        lambda _, friction: sigma * (1.0 - direction * friction / coulomb) * direction,
        (0.0, path[-1]), [-direction * coulomb], t_eval=path, rtol=1e-10, atol=1e-10,
    ).y[0]  # fmt: skip
    motion = replace(strokes((0.1,), 1.0).block(slice(len(path))), velocity=np.full(len(path), direction), travel=path)
    missing = 2.0 * sigma * EFFECT.motion_columns(PLACE, CHAIN, motion, {"angle": coulomb / sigma})["stiffness"]
    np.testing.assert_allclose(coulomb * direction + missing, dahl, atol=1e-6 * coulomb)


def test_nothing_is_added_where_the_reversal_is_not_logged() -> None:
    motion = replace(strokes((0.1,), 1.0), travel=np.full(1000, np.nan))
    np.testing.assert_array_equal(EFFECT.motion_columns(PLACE, CHAIN, motion, {"angle": 0.1})["stiffness"], 0.0)


def test_angles_lie_within_what_was_travelled() -> None:
    angles = EFFECT.motion_grid(PLACE, CHAIN, strokes((0.01, 0.1), 0.3))["angle"]
    assert angles.min() < 0.002
    assert angles.max() == pytest.approx(0.1, rel=0.02)


def test_what_is_missing_is_named() -> None:
    motion = strokes((0.1, 0.4), 1.0)
    assert EFFECT.lacking_motion(CHAIN, motion) is None
    unknown = replace(motion, travel=np.full(len(motion), np.nan))
    assert "contain reversals" in str(EFFECT.lacking_motion(CHAIN, unknown))
    late = motion.block(motion.travel > 0.5)
    assert "soon after a reversal" in str(EFFECT.lacking_motion(CHAIN, late))
