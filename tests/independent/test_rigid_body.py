"""The torques of a rigid chain in motion against pinocchio's recursive Newton-Euler algorithm."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.mechanics.rigid_body import PER_LINK, inertial_regressor, rigid_torque
from tests.laboratory.pinocchio_robot import pinocchio_model
from tests.laboratory.robots import six_axes

pin: Any = pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")
CHAIN = six_axes()
RNG = np.random.default_rng(5)
ANGLES, VELOCITY, ACCELERATION = (RNG.normal(size=(7, 6)) * size for size in (1.0, 2.0, 5.0))


def test_links_of_any_inertia() -> None:
    model = pinocchio_model(CHAIN)
    numbers = np.zeros((6, PER_LINK))
    for k in range(6):
        mass, centre = float(RNG.uniform(5.0, 50.0)), RNG.normal(size=3) * 0.2
        root = RNG.normal(size=(3, 3))
        about_centre = root @ root.T
        model.inertias[k + 1] = pin.Inertia(mass, centre, about_centre)
        spread = about_centre + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        numbers[k] = [mass, *(mass * centre), *spread[np.triu_indices(3)]]
    data = model.createData()
    wanted = [pin.rnea(model, data, *state).copy() for state in zip(ANGLES, VELOCITY, ACCELERATION, strict=True)]
    found = inertial_regressor(CHAIN, ANGLES, VELOCITY, ACCELERATION) @ numbers.ravel()
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-8)


def test_point_masses_of_the_robot_file() -> None:
    model = pinocchio_model(CHAIN)
    data = model.createData()
    wanted = [pin.rnea(model, data, *state).copy() for state in zip(ANGLES, VELOCITY, ACCELERATION, strict=True)]
    np.testing.assert_allclose(rigid_torque(CHAIN, ANGLES, VELOCITY, ACCELERATION), wanted, rtol=1e-10, atol=1e-8)
