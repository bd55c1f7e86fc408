"""The balance of joint springs in dual quaternions: its derivative, and the same rest as the matrix form."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.dual_balance import (
    complementary_stiffness,
    dual_rest,
    joint_torques,
    reading_as_load,
    weights_of,
)
from stiffcal.mechanics.dual_quaternions import attached_duals, displacement_of_duals, dual_chain
from stiffcal.model.balance.equilibrium import solve_balance
from tests.laboratory.robots import SEVEN_STIFFNESS, SIX_STIFFNESS, force_sensor_setup, seven_axes, six_axes
from tests.laboratory.simulated_states import joint_springs

ROBOTS = pytest.mark.parametrize(
    ("chain", "stiffness"), [(six_axes(), SIX_STIFFNESS), (seven_axes(), SEVEN_STIFFNESS)], ids=["six", "seven"]
)


def states(chain: Chain) -> tuple[Floats, Floats, MeasurementSetup]:
    """Return angles, wrenches and set-up; the first states stretch the arm and the wrist: singular."""
    rng = np.random.default_rng(7)
    angles = rng.uniform(-2.0, 2.0, (12, chain.n_joints))
    angles[0] = 0.0
    angles[1, -3:] = 0.0
    wrench = rng.normal(size=(12, 6)) * np.repeat([150.0, 20.0], 3)
    return angles, wrench, force_sensor_setup(chain, tool_mass=3.0, tool_com=(0.02, 0.01, 0.05))


@ROBOTS
def test_complementary_stiffness_is_the_torque_s_derivative(chain: Chain, stiffness: Floats) -> None:
    angles, wrench, setup = states(chain)
    loads = [*weights_of(chain, setup, len(angles)), reading_as_load(setup, wrench)]
    found = complementary_stiffness(dual_chain(chain, angles), loads)
    step = 1e-6
    for j in range(chain.n_joints):
        sides = [
            joint_torques(dual_chain(chain, angles + s * step * np.eye(chain.n_joints)[j]), loads) for s in (1, -1)
        ]
        assert np.allclose(found[:, :, j], (sides[0] - sides[1]) / (2.0 * step), atol=1e-6 * np.abs(found).max())
    # a load that turns with the tool is not conservative: K_C need not be symmetric, and is not
    assert np.abs(found - np.swapaxes(found, 1, 2)).max() > 1.0


@ROBOTS
def test_rests_where_the_matrix_form_rests(chain: Chain, stiffness: Floats) -> None:
    angles, wrench, setup = states(chain)
    weights = weights_of(chain, setup, len(angles))
    compliance = np.diag(1.0 / stiffness)
    loaded = dual_chain(chain, dual_rest(chain, compliance, angles, [*weights, reading_as_load(setup, wrench)]))
    unloaded = dual_chain(chain, dual_rest(chain, compliance, angles, weights))
    target = setup.targets[0]
    moved = displacement_of_duals(attached_duals(loaded, target), attached_duals(unloaded, target))
    balance = solve_balance(joint_springs(chain, stiffness), angles, wrench, setup)
    assert np.allclose(moved, balance.displacement[:, 0], atol=1e-11)
    assert np.abs(moved).max() > 1e-3


def test_more_than_the_springs_hold() -> None:
    chain = six_axes()
    angles, wrench, setup = states(chain)
    with pytest.raises(ArithmeticError, match="exceeds what the springs can carry"):
        dual_rest(chain, np.eye(6) * 0.05, angles, [reading_as_load(setup, wrench * 50.0)])
