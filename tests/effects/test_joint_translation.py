"""joint-translation: three translations over three forces."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.joint_translation import JointTranslation
from stiffcal.model.effect import TX, TY, TZ, Place, joint_node
from stiffcal.model.forms import form_of
from tests.laboratory.effect_bench import displacement, loads, nonzero, robot_chain, settled

EFFECT = JointTranslation()
COMPLIANCE = {"tx": 1e-8, "ty": 2e-8, "tz": 3e-8}


def test_each_direction_by_its_own_force() -> None:
    node = joint_node(5)
    moved = displacement(
        EFFECT,
        Place("joints", (5,)),
        COMPLIANCE,
        loads({(node, TX): [100.0], (node, TY): [100.0], (node, TZ): [-100.0]}),
    )
    np.testing.assert_allclose(moved[node, :3, 0], [1e-6, 2e-6, -3e-6])
    assert nonzero(moved) == {(node, TX), (node, TY), (node, TZ)}


def test_equal_compliance_moves_the_target_along_the_force_without_turning() -> None:
    rng = np.random.default_rng(1)
    chain = robot_chain()
    joints, force = rng.uniform(-1, 1, (5, 6)), rng.normal(0, 300, (5, 6))
    values = dict.fromkeys(COMPLIANCE, 1e-7)
    found = settled([(EFFECT, Place("joints", (3,)), values)], chain.model_angles(joints), force)
    assert np.abs(found.displacement[:, 0, 3:]).max() < 1e-12
    np.testing.assert_allclose(
        np.linalg.norm(found.displacement[:, 0, :3], axis=1), 1e-7 * np.linalg.norm(force[:, :3], axis=1), rtol=1e-9
    )


def test_curved_form() -> None:
    node = joint_node(5)
    curved = form_of(EFFECT, ["tz2"])
    carried = loads({(node, TZ): [1000.0, -1000.0], (node, TX): [100.0, 100.0]})
    values = {"tx": 1e-8, "tz": 2e-9, "tz2": 1e-12, "tz3": 3e-15}
    moved = displacement(curved, Place("joints", (5,)), values, carried)
    np.testing.assert_allclose(moved[node, TZ], [2e-6 + 1e-6 + 3e-6, -2e-6 + 1e-6 - 3e-6])
    np.testing.assert_allclose(moved[node, TX], [1e-6, 1e-6])
