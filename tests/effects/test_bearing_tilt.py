"""bearing-tilt: δ_Rx = c_x M_x, δ_Ry = c_y M_y."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.bearing_tilt import BearingTilt
from stiffcal.model.effect import RX, RY, RZ, Place, joint_node
from stiffcal.model.forms import curve_of, form_of
from tests.laboratory.effect_bench import displacement, loads, nonzero, robot_chain, settled
from tests.laboratory.robots import force_sensor_setup

EFFECT = BearingTilt()


def test_each_axis_by_its_own_moment() -> None:
    node = joint_node(2)
    carried = loads({(node, RX): [1000.0], (node, RY): [-500.0], (node, RZ): [7.0]})
    moved = displacement(EFFECT, Place("joints", (2,)), {"x": 1e-7, "y": 4e-7}, carried)
    np.testing.assert_allclose(moved[node, RX], [1e-4])
    np.testing.assert_allclose(moved[node, RY], [-2e-4])
    assert nonzero(moved) == {(node, RX), (node, RY)}


def test_table_1_of_paper_000() -> None:
    """1.5e7 N·m/rad at joint 2: 3 kN at 2 m tilts it by 0.4 mrad."""
    node = joint_node(2)
    moved = displacement(EFFECT, Place("joints", (2,)), {"y": 1 / 1.5e7}, loads({(node, RY): [6000.0]}))
    np.testing.assert_allclose(moved[node, RY], [4e-4])


def test_tilt_of_joint_1_lowers_the_target_under_weight_of_the_load() -> None:
    """Joint 1's y axis is the base's y: a downward force in front of it tips the robot forward, x and z as a lever."""
    chain = robot_chain()
    joints = chain.model_angles(np.radians([[0.0, -60.0, 30.0, 0.0, 20.0, 0.0]]))
    place = settled([], joints, np.zeros((1, 6))).target_position[0, 0]
    down = np.array([[0.0, 0.0, -200.0, 0.0, 0.0, 0.0]])
    setup = force_sensor_setup(chain)
    setup = replace(
        setup, wrench_axes=replace(setup.wrench_axes, body=0, transform=np.eye(4)), wrench_point=setup.targets[0]
    )
    found = settled([(EFFECT, Place("joints", (1,)), {"y": 1e-7})], joints, down, setup).displacement[0, 0]
    turn = 1e-7 * 200.0 * place[0]
    height = place[2] - 0.68  # joint 1's frame lies 0.68 m above the base
    np.testing.assert_allclose(found[4], turn, rtol=2e-3)
    np.testing.assert_allclose(found[[0, 2]], [turn * height, -turn * place[0]], rtol=2e-3, atol=1e-7)


def test_curved_form() -> None:
    node = joint_node(2)
    curved = form_of(EFFECT, ["x", "x3"])
    carried = loads({(node, RX): [1000.0, -500.0], (node, RY): [200.0, 200.0]})
    moved = displacement(curved, Place("joints", (2,)), {"x": 1e-7, "x2": 2e-11, "x3": -4e-14, "y": 1e-7}, carried)
    np.testing.assert_allclose(moved[node, RX], [1e-4 + 2e-5 - 4e-5, -5e-5 + 5e-6 + 5e-6])
    np.testing.assert_allclose(moved[node, RY], [2e-5, 2e-5])
    assert form_of(EFFECT, ["x", "y"]) is EFFECT
    assert form_of(curved, ["x"]) is curved
    assert curve_of(EFFECT) is curved
