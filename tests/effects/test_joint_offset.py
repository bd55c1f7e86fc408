"""joint-offset: the offset is added to the logged angle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.joint_offset import JointOffset
from stiffcal.mechanics.kinematics import body_poses
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.effect_bench import bare_states, robot_chain

EFFECT = JointOffset()


def test_it_is_added_to_the_logged_angle_before_direction_and_coupling() -> None:
    coupling = np.diag([1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
    coupling[2, 1] = 1.0
    chain = replace(robot_chain(), coupling=coupling)
    logged = np.random.default_rng(2).uniform(-1.0, 1.0, (5, 6))
    zeros = {2: 3e-3, 3: -2e-3}
    placed = tuple(PlacedEffect(EFFECT, Place("joints", (k,)), {"zero": zero}) for k, zero in zeros.items())
    moved = logged.copy()
    for joint, zero in zeros.items():
        moved[:, joint - 1] += zero
    expected, _ = body_poses(chain, chain.model_angles(moved))
    found, _ = body_poses(CompliantRobot(chain, placed).adjusted_chain, chain.model_angles(logged))
    np.testing.assert_allclose(found, expected, atol=1e-14)


def test_displacements_do_not_show_it() -> None:
    assert "absolute" in (EFFECT.lacking(robot_chain(), bare_states([0, 1])) or "")
