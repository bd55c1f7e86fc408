"""asymmetric-stiffness: c · max(τ, 0)."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.asymmetric_stiffness import AsymmetricStiffness
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import displacement, loads

EFFECT = AsymmetricStiffness()


def test_only_positive_torque() -> None:
    node = joint_node(6)
    moved = displacement(EFFECT, Place("joints", (6,)), {"c": -2e-6}, loads({(node, RZ): [-50.0, 0.0, 50.0]}))
    np.testing.assert_allclose(moved[node, RZ], [0.0, 0.0, -1e-4])


def test_either_sign_is_possible() -> None:
    assert EFFECT.spec("c").lower < 0.0 < EFFECT.spec("c").upper
