"""The noise of a clamped run's wrench that drives at rest show: known where they cannot turn, left where they do."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.identification.readings.joints_at_rest import _noise_of

STATES = 4000
SIZES = np.array([0.4, 0.5, 0.45, 0.05, 0.04, 0.06])
DRIVEN = 2


def jacobian() -> Floats:
    """Return (6, 6) of a robot far from singular poses, m and rad per rad."""
    return np.random.default_rng(4).normal(size=(6, 6)) + 2.0 * np.eye(6)


def read_wrenches(other: float = 0.0) -> tuple[Floats, Floats, Floats]:
    """Return true and read wrenches (6, n) and the driven torque's sine; ``other`` N·m of its square on another."""
    rng = np.random.default_rng(7)
    wave = np.sin(np.linspace(0.0, 6.0 * np.pi, STATES))
    torques = np.zeros((6, STATES))
    torques[DRIVEN], torques[4] = 300.0 * wave, other * (wave**2 - np.mean(wave**2))
    wrench = np.linalg.solve(jacobian().T, torques)
    read = np.asarray(wrench + SIZES[:, None] * rng.standard_normal((6, STATES)))
    return np.asarray(wrench), read, np.asarray(wave)


def cleaned(read: Floats) -> tuple[Floats, float] | None:
    """Return what the noise is taken for, and by what the driven torque's uncertainty falls."""
    columns = jacobian()
    sigma = np.repeat(SIZES[:, None], STATES, axis=1)
    return _noise_of(read, sigma, np.delete(columns, DRIVEN, axis=1), columns[:, DRIVEN])


def beyond(values: Floats, wave: Floats) -> Floats:
    """Return (n,) values without what follows a wave (n,) of mean zero: that may be a turned Jacobian, and stays."""
    return values - wave * (values @ wave) / (wave @ wave)


def test_the_driven_torque_is_known_as_well_as_stated() -> None:
    true, read, wave = read_wrenches()
    result = cleaned(read)
    assert result is not None
    noise, share = result
    own = jacobian()[:, DRIVEN]
    before, after = (np.std(beyond(own @ (values - true), wave)) for values in (read, read - noise))
    # a standard deviation of 4000 values is known to 1.1 %
    assert after == pytest.approx(share * before, rel=0.04)
    # weighted least squares with the constraint that the other torques are zero: 1/√(uᵀ Σ⁻¹ u)
    along = np.linalg.inv(jacobian())[DRIVEN]
    assert after == pytest.approx(1.0 / np.linalg.norm(along / SIZES), rel=0.04)
    others = np.delete(jacobian(), DRIVEN, axis=1).T
    assert np.std(others @ (read - noise), axis=1).max() < 0.05 * np.std(others @ read, axis=1).min()


def test_what_follows_the_driven_torque_is_no_noise() -> None:
    """An unknown sag turns the Jacobian: a share of the driven torque seems to turn the others."""
    _, read, wave = read_wrenches()
    leaked = read + np.linalg.solve(jacobian().T, np.outer(np.eye(6)[4], 3.0 * wave))
    plain, result = cleaned(read), cleaned(leaked)
    assert plain is not None
    assert result is not None
    np.testing.assert_allclose(result[0], plain[0], atol=0.05 * SIZES.max())


def test_other_joints_that_turn_are_left_alone() -> None:
    """A law of its own at another joint, five times the noise of that joint's torque."""
    _, read, _ = read_wrenches()
    noise_of_torque = float(np.linalg.norm(jacobian()[:, 4] * SIZES))
    _, turned, _ = read_wrenches(other=5.0 * noise_of_torque)
    assert cleaned(read) is not None
    assert cleaned(turned) is None
