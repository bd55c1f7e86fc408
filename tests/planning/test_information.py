"""What a run would bring agrees with what a fit to such runs finds, and with the textbook's first-order formula."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.measurements.load_states import Attachment, Gauge, Sigma
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.planning.design import information
from stiffcal.planning.information import information_of_runs, prediction_rows
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes, six_axis_joints
from tests.laboratory.simulated_states import cycles_of, joint_springs, medium_robot, played

TRACKER = Sigma(translation=2e-5, rotation=3e-5, force=1.0, moment=0.3)
NOISE = Noise(2e-5, 3e-5, 1.0, 0.3, "manifest", np.inf)


def steps_of(directions: Floats) -> Floats:
    """Return the loads of a run between its first and its last state, which are unloaded."""
    return cycles_of(directions)[1:-1]


def test_expected_uncertainty_is_that_of_a_fit() -> None:
    robot = medium_robot()
    rng = np.random.default_rng(4)
    directions = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(6)]
    states = played(robot, wrench=[cycles_of(one) for one in directions], noise=TRACKER)
    fit = identify_parameters(states, robot, Settings(noise=NOISE))
    joints = states.joints[states.reference]
    expected = information_of_runs(
        robot, joints, np.stack([steps_of(one) for one in directions]), states.setup, NOISE, with_rotation=True
    )
    covariance = np.linalg.inv(information(expected.factors).sum(axis=0))
    assert expected.names == fit.free_names
    fitted = np.sqrt(np.diagonal(fit.covariance)) / expected.scale
    # the fit stands at estimates that noise moved by half a per cent
    np.testing.assert_allclose(np.sqrt(np.diagonal(covariance)), fitted, rtol=0.02)


def test_one_joint_brings_what_the_jacobian_says() -> None:
    """Without deformation d = J_k c τ_k, τ_k = J_kᵀ w; with the run's offset load steps s count as Σs² - (Σs)²/n."""
    chain = six_axes()
    robot = joint_springs(chain, SIX_STIFFNESS, deformed=False)
    setup = replace(force_sensor_setup(chain), tool_mass=0.0)
    joints = six_axis_joints(np.random.default_rng(8), 5)
    full = np.array([120.0, -300.0, 210.0, 10.0, -20.0, 5.0])
    steps = np.array([0.25, 0.5, 1.0])
    wrench = np.tile(steps[:, None] * full, (5, 1, 1))
    noise = Noise(2e-5, 0.0, 0.0, 0.0, "manifest", np.inf)
    found = information_of_runs(robot, joints, wrench, setup, noise, with_rotation=False)
    angles = chain.model_angles(joints)
    at_target = jacobians(chain, angles, setup.targets[0])[:, :3]
    at_sensor = jacobians(chain, angles, setup.wrench_point)
    _, rotation = attached_poses(chain, angles, setup.wrench_axes)
    base = np.concatenate([rotation @ full[:3], rotation @ full[3:]], axis=1)
    torque = np.einsum("nik,ni->nk", at_sensor, base)
    column = at_target * torque[:, None] / SIX_STIFFNESS
    # two unloaded readings belong to the run
    factor = np.sum(steps**2) - np.sum(steps) ** 2 / (len(steps) + 2)
    expected = factor * np.einsum("nik,nil->nkl", column, column) / noise.translation**2
    np.testing.assert_allclose(information(found.factors), expected, rtol=1e-6, atol=1e-9 * expected.max())


def test_noise_of_the_wrench_takes_information_away() -> None:
    robot, chain = medium_robot(), six_axes()
    setup = force_sensor_setup(chain)
    joints = six_axis_joints(np.random.default_rng(8), 3)
    wrench = np.stack([steps_of(np.eye(3))] * 3)
    without, with_noise = (
        information(information_of_runs(robot, joints, wrench, setup, noise, with_rotation=True).factors)
        for noise in (replace(NOISE, force=0.0, moment=0.0), replace(NOISE, force=20.0))
    )
    assert (np.linalg.eigvalsh(without - with_noise) >= -1e-6 * without.max()).all()
    assert np.trace(with_noise[0]) < 0.5 * np.trace(without[0])


def test_rows_of_predictions_are_the_change_with_the_parameter() -> None:
    # without weight and deformation, columns of a Gauss-Newton step are the derivative
    chain = six_axes()
    robot = joint_springs(chain, SIX_STIFFNESS, deformed=False)
    setup = force_sensor_setup(chain)
    joints = six_axis_joints(np.random.default_rng(2), 4)
    wrench = np.tile([100.0, -200.0, 300.0, 5.0, 6.0, -7.0], (4, 1))
    scale = 1.0 / SIX_STIFFNESS
    rows = prediction_rows(robot, joints, wrench, setup, scale)
    angles = chain.model_angles(joints)
    for k in range(6):
        ends = [
            solve_balance(
                joint_springs(chain, SIX_STIFFNESS / (1.0 + sign * 1e-3 * (np.arange(6) == k)), deformed=False),
                angles, wrench, setup,
            ).displacement[:, 0, :3]
            for sign in (1.0, -1.0)
        ]  # fmt: skip
        difference = (ends[0] - ends[1]) / 2e-3
        change = rows[:, k].reshape(3, 4).T
        np.testing.assert_allclose(change, difference, atol=1e-5 * np.abs(difference).max() + 1e-12)


def test_devices_read_along_their_lines_alone() -> None:
    """Of a run with one load step the readings are 0, d, 0 along the nearest line: (2/3) d dᵀ/σ² about their mean."""
    robot, base = joint_springs(six_axes(), SIX_STIFFNESS), Attachment(0, np.eye(4))
    lines = tuple(Gauge(name, 0, base, line) for name, line in zip("xyz", np.eye(3), strict=True))
    setup = replace(force_sensor_setup(robot.chain), gauges=lines, wrench_axes=base)
    noise = Noise(0.0, 0.0, 0.0, 0.0, "manifest", np.inf, gauge=2e-5)
    joints = six_axis_joints(np.random.default_rng(1), 4)
    wrench = np.tile([10.0, 300.0, -20.0, 0.0, 0.0, 0.0], (4, 1))
    runs = information_of_runs(robot, joints, wrench[:, None], setup, noise, False)
    along_y = prediction_rows(robot, joints, wrench, setup, runs.scale).reshape(3, -1, 6)[1]
    for factor, moved in zip(runs.factors, along_y, strict=True):
        expected = 2.0 / 3.0 * np.outer(moved, moved) / noise.gauge**2
        np.testing.assert_allclose(factor.T @ factor, expected, rtol=1e-4, atol=1e-6 * expected.max())
