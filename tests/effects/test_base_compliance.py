"""base-compliance: a diagonal compliance at the base's origin, base axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.effects.base_compliance import BaseCompliance
from stiffcal.model.effect import BASE_NODE, Place
from tests.laboratory.effect_bench import displacement, loads, robot_chain, settled
from tests.laboratory.robots import force_sensor_setup

EFFECT = BaseCompliance()
VALUES = {"tx": 1e-8, "ty": 2e-8, "tz": 3e-8, "rx": 1e-7, "ry": 2e-7, "rz": 3e-7}


def test_diagonal() -> None:
    carried = loads({(BASE_NODE, k): [100.0 * (k + 1)] for k in range(6)})
    moved = displacement(EFFECT, Place("setup"), VALUES, carried)[BASE_NODE, :, 0]
    np.testing.assert_allclose(moved, [1e-6, 4e-6, 9e-6, 4e-5, 1e-4, 1.8e-4])


def test_units() -> None:
    units = {spec.symbol: spec.unit for spec in EFFECT.parameters}
    assert units == {f"r{axis}": "rad/(N·m)" for axis in "xyz"} | {f"t{axis}": "m/N" for axis in "xyz"}


def test_the_robot_leans_about_the_base_wherever_joint_1_points() -> None:
    """F along base x at height h: turn F h about base y, target moves by turn × place.

    To a thousandth: the links lean too, and their weight adds to the turn.
    """
    chain = robot_chain()
    setup = force_sensor_setup(chain)
    setup = replace(
        setup, wrench_axes=replace(setup.wrench_axes, body=0, transform=np.eye(4)), wrench_point=setup.targets[0]
    )
    joints = chain.model_angles(np.radians([[angle, -70.0, 20.0, 30.0, 40.0, 50.0] for angle in (-60.0, 0.0, 45.0)]))
    wrench = np.tile([250.0, 0.0, 0.0, 0.0, 0.0, 0.0], (3, 1))
    found = settled([(EFFECT, Place("setup"), {"ry": 1e-7})], joints, wrench, setup)
    place = found.unloaded_position[:, 0]
    turn = np.zeros((3, 3))
    turn[:, 1] = 1e-7 * 250.0 * place[:, 2]
    np.testing.assert_allclose(found.displacement[:, 0, 3:], turn, rtol=1e-3, atol=1e-12)
    np.testing.assert_allclose(found.displacement[:, 0, :3], np.cross(turn, place), rtol=1e-3, atol=1e-7)
