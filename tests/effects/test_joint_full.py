"""joint-full: δ = C w with C symmetric; what it includes, it reproduces."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.bearing_tilt import BearingTilt
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.joint_full import JointFull
from stiffcal.effects.joint_translation import JointTranslation
from stiffcal.model.effect import Place, joint_node
from tests.laboratory.effect_bench import displacement, loads

EFFECT = JointFull()
PLACE = Place("joints", (4,))
NODE = joint_node(4)


def random_load(rng: np.random.Generator) -> dict[tuple[int, int], np.ndarray]:
    return {(NODE, component): rng.normal(size=3) for component in range(6)}


def test_product_with_a_symmetric_matrix() -> None:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(6, 6))
    compliance = root @ root.T
    values = {f"c{i + 1}{j + 1}": compliance[i, j] for i in range(6) for j in range(i, 6)}
    assert set(values) == {spec.symbol for spec in EFFECT.parameters}
    carried = loads(random_load(rng))
    moved = displacement(EFFECT, PLACE, values, carried)
    np.testing.assert_allclose(moved[NODE], compliance @ carried.wrench[NODE], rtol=1e-12)
    assert EFFECT.impossible(values) is None


def test_it_contains_the_three_simple_effects() -> None:
    carried = loads(random_load(np.random.default_rng(4)))
    simple = (
        displacement(JointTranslation(), PLACE, {"tx": 1.0, "ty": 2.0, "tz": 3.0}, carried)
        + displacement(BearingTilt(), PLACE, {"x": 4.0, "y": 5.0}, carried)
        + displacement(JointCompliance(), PLACE, {"c": 6.0}, carried)
    )
    whole = {f"c{k}{k}": float(k) for k in range(1, 7)}
    np.testing.assert_allclose(displacement(EFFECT, PLACE, whole, carried), simple)


def test_a_compliance_that_gives_energy_away_is_impossible() -> None:
    reason = EFFECT.impossible({"c44": 1e-7, "c66": 1e-7, "c46": 2e-7})
    assert reason is not None
    assert "negative eigenvalue" in reason
    assert EFFECT.impossible({"c44": 1e-7, "c66": 1e-7, "c46": 0.9e-7}) is None


def test_a_compliance_that_just_holds_is_possible() -> None:
    assert EFFECT.impossible({"c44": 1e-7, "c66": 1e-7, "c46": 1e-7}) is None


def test_units_bounds_and_sizes_follow_the_block() -> None:
    blocks = {"c12": ("m/N", 5e-9), "c35": ("rad/N", 2.6e-8), "c46": ("rad/(N·m)", 1.4e-7)}
    for symbol, (unit, typical) in blocks.items():
        assert (EFFECT.spec(symbol).unit, EFFECT.spec(symbol).typical) == (unit, typical)
        assert EFFECT.spec(symbol).lower == -EFFECT.spec(symbol).upper
    for k in range(1, 7):
        assert EFFECT.spec(f"c{k}{k}").lower == 0.0
        assert EFFECT.spec(f"c{k}{k}").compliance
