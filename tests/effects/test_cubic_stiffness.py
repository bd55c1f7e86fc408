"""cubic-stiffness: δ = c2 τ² + c3 τ³, the inverse of paper 004's polynomial to third order."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.cubic_stiffness import CubicStiffness
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.model.effect import RZ, Place, joint_node
from tests.laboratory.effect_bench import displacement, loads

EFFECT = CubicStiffness()
PLACE = Place("joints", (3,))
NODE = joint_node(3)


def test_square_and_cube() -> None:
    moved = displacement(EFFECT, PLACE, {"c2": 3e-10, "c3": -2e-13}, loads({(NODE, RZ): [1000.0, -500.0]}))
    np.testing.assert_allclose(moved[NODE, RZ], [3e-4 - 2e-4, 7.5e-5 + 2.5e-5])


def test_paper_004_table_2_joint_2_turned_round() -> None:
    """τ = −42.5 φ³ − 5.30 φ² + 6.35 φ (10³ N·m, degrees): inverted to third order it gives φ back to fourth order."""
    degree = np.radians(1.0)
    p1, p2, p3 = 6.35e3 / degree, -5.30e3 / degree**2, -42.5e3 / degree**3
    values = {"c2": -p2 / p1**3, "c3": (2 * p2**2 - p1 * p3) / p1**5}
    np.testing.assert_allclose(values["c2"], 3.61e-10, rtol=2e-3)
    np.testing.assert_allclose(values["c3"], 5.5e-13, rtol=2e-2)
    for angle in (np.radians(0.02), np.radians(0.01), -np.radians(0.01)):
        torque = p1 * angle + p2 * angle**2 + p3 * angle**3
        carried = loads({(NODE, RZ): [float(torque)]})
        found = displacement(EFFECT, PLACE, values, carried) + displacement(
            JointCompliance(), PLACE, {"c": 1 / p1}, carried
        )
        np.testing.assert_allclose(found[NODE, RZ, 0], angle, rtol=5e-4)
