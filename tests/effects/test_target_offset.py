"""target-offset: the target's true place is the manifest's plus the offset, flange axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.target_offset import TargetOffset
from stiffcal.measurements.load_states import Attachment
from stiffcal.model.effect import Inputs, Place
from tests.laboratory.effect_bench import bare_states, robot_chain, settled
from tests.laboratory.robots import force_sensor_setup, shifted

EFFECT = TargetOffset()
PLACE = Place("setup")
OFFSET = {"x": 0.01, "y": -0.02, "z": 0.03}


def test_the_tools_turn_times_the_offset() -> None:
    rng = np.random.default_rng(13)
    chain = robot_chain()
    joints = chain.model_angles(rng.uniform(-1, 1, (4, 6)))
    wrench = rng.normal(0.0, 100.0, (4, 6))
    springs = [(JointCompliance(), Place("joints", (k,)), {"c": 1e-6}) for k in range(1, 7)]
    plain = settled(springs, joints, wrench)
    found = settled([*springs, (EFFECT, PLACE, OFFSET)], joints, wrench)
    np.testing.assert_allclose(found.displacement[..., 3:], plain.displacement[..., 3:], atol=1e-13)
    # the target's own axes are turned by −0.3 rad about x against the flange's
    c, s = np.cos(0.3), np.sin(0.3)
    flange_from_target = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    offset = plain.unloaded_rotation[:, 0] @ flange_from_target.T @ list(OFFSET.values())
    expected = np.cross(plain.displacement[:, 0, 3:], offset)
    moved = found.displacement[:, 0, :3] - plain.displacement[:, 0, :3]
    np.testing.assert_allclose(moved, expected, atol=2e-3 * np.abs(expected).max())


def test_targets_on_links_stay() -> None:
    chain = robot_chain()
    setup = force_sensor_setup(chain)
    on_link = Attachment(3, shifted(0.1, 0.0, 0.0))
    both = replace(setup, targets=(on_link, *setup.targets))
    moved = EFFECT.adjusted(PLACE, Inputs(np.zeros((6, 1)), np.ones((6, 1)), both), OFFSET).setup.targets
    np.testing.assert_array_equal(moved[0].transform, on_link.transform)
    np.testing.assert_allclose(moved[1].transform[:3, 3] - setup.targets[0].transform[:3, 3], list(OFFSET.values()))
    only_link = replace(setup, targets=(on_link,))
    assert "flange" in str(EFFECT.lacking(chain, bare_states([0], setup=only_link)))
    assert EFFECT.lacking(chain, bare_states([0], setup=both)) is None
