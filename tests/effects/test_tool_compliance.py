"""tool-compliance: a diagonal compliance at the flange's origin, flange axes."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.tool_compliance import ToolCompliance
from stiffcal.model.effect import Place, tool_node
from tests.laboratory.effect_bench import displacement, loads, robot_chain, settled

EFFECT = ToolCompliance()
VALUES = {"tx": 1e-8, "ty": 2e-8, "tz": 3e-8, "rx": 1e-6, "ry": 2e-6, "rz": 3e-6}


def test_diagonal() -> None:
    node = tool_node(robot_chain())
    carried = loads({(node, k): [10.0 * (k + 1)] for k in range(6)})
    moved = displacement(EFFECT, Place("setup"), VALUES, carried)[node, :, 0]
    np.testing.assert_allclose(moved, [1e-7, 4e-7, 9e-7, 4e-5, 1e-4, 1.8e-4])


def test_units() -> None:
    units = {spec.symbol: spec.unit for spec in EFFECT.parameters}
    assert units == {f"r{axis}": "rad/(N·m)" for axis in "xyz"} | {f"t{axis}": "m/N" for axis in "xyz"}


def test_the_same_in_every_pose_seen_from_the_flange() -> None:
    rng = np.random.default_rng(7)
    chain = robot_chain()
    joints = chain.model_angles(rng.uniform(-1, 1, (6, 6)))
    wrench = np.tile([100.0, -50.0, 80.0, 5.0, 6.0, -7.0], (6, 1))
    found = settled([(EFFECT, Place("setup"), VALUES)], joints, wrench)
    local = np.einsum("nji,nj->ni", found.unloaded_rotation[:, 0], found.displacement[:, 0, :3])
    np.testing.assert_allclose(local, np.tile(local[0], (6, 1)), rtol=1e-6, atol=1e-10)
    assert np.linalg.norm(local[0]) > 1e-6
