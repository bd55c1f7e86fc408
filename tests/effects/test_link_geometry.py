"""link-geometry: N · Trans(x, y, 0) · Exp(rx, ry, 0) · Rz(θ)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.absolute_places import absolute_states
from tests.laboratory.effect_bench import bare_states, robot_chain

EFFECT = LinkGeometry()
VALUES = {"x": 4e-4, "y": -3e-4, "rx": 2e-3, "ry": -1e-3}


@pytest.mark.parametrize("joint", [1, 4, 6])
def test_law(joint: int) -> None:
    chain = robot_chain()
    changed = CompliantRobot(chain, (PlacedEffect(EFFECT, Place("joints", (joint,)), VALUES),)).adjusted_chain
    shift = np.eye(4)
    shift[:3, 3] = [4e-4, -3e-4, 0.0]
    shift[:3, :3] = Rotation.from_rotvec([2e-3, -1e-3, 0.0]).as_matrix()
    np.testing.assert_allclose(changed.fixed[joint - 1], chain.fixed[joint - 1] @ shift, atol=1e-15)
    others = [k for k in range(6) if k != joint - 1]
    np.testing.assert_array_equal(changed.fixed[others], chain.fixed[others])


def test_it_replaces_the_joints_zero() -> None:
    assert EFFECT.includes == ("joint-offset",)


def test_displacements_do_not_show_it() -> None:
    chain = robot_chain()
    assert "absolute" in (EFFECT.lacking(chain, bare_states([0, 1])) or "")
    assert EFFECT.lacking(chain, absolute_states(chain, 3, 1)) is None
