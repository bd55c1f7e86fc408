"""A chain with another value of one effect is the chain built anew with it, also where effects share a joint."""

import dataclasses

import numpy as np

from stiffcal.effects.joint_offset import JointOffset
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.random_chains import draw_chain


def test_every_effect_on_the_joint_acts_anew() -> None:
    chain = draw_chain(4).robot.chain
    second = Place("joints", (2,))
    placed = (
        PlacedEffect(LinkGeometry(), second, {"x": 1e-3, "rx": 2e-3}),
        PlacedEffect(JointOffset(), Place("joints", (1,)), {"zero": 2e-3}),
        PlacedEffect(JointOffset(), second, {"zero": 0.3}),
    )
    robot = CompliantRobot(chain, placed)
    for number, values in ((0, {"x": 2e-3, "ry": 1e-2}), (1, {"zero": 0.1}), (2, {"zero": 0.0})):
        others = (*placed[:number], dataclasses.replace(placed[number], values=values), *placed[number + 1 :])
        expected = CompliantRobot(chain, others).adjusted_chain.fixed
        np.testing.assert_array_equal(robot.fixed_with(number, values), expected)
        assert not np.array_equal(expected, robot.adjusted_chain.fixed)
