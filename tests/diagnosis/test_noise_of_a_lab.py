"""Noise as labs have it (lingering, wider in one run, stated too small) lacks no effect; a wandering target does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.judgement.document import diagnosis_result
from stiffcal.judgement.rows_off import Off
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.reduction.set_aside.outliers import reject_outliers
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import cycles_of, joint_springs, medium_robot, played

TRACKER = 16e-6


def still(cycles: int = 2) -> LoadStates:
    """Return eight poses read by a tracker without noise."""
    rng = np.random.default_rng(1)
    wrench = [cycles_of(np.linalg.qr(rng.normal(size=(3, 3)))[0], cycles) for _ in range(8)]
    return played(medium_robot(), 8, wrench=wrench, noise=Sigma(1e-9, 1e-9, 0.0, 0.0), load_scatter=0.03, seed=5)


def read_with(states: LoadStates, noise: Floats) -> LoadStates:
    """Return position readings, off by so much (n, 3)."""
    rotation = np.full_like(states.rotation, np.nan)
    return replace(states, position=states.position + noise[:, None], rotation=rotation)


def diagnosed(states: LoadStates) -> DiagnosedStates:
    """Judge the right model, nothing else at hand."""
    return diagnose_states(states, joint_springs(six_axes()), {})


def lingering(states: LoadStates, keep: float) -> Floats:
    """Return noise of which so much is left at the next reading."""
    noise = np.random.default_rng(3).normal(size=(len(states), 3))
    for k in range(1, len(noise)):
        if states.run[k] == states.run[k - 1]:
            noise[k] = keep * noise[k - 1] + np.sqrt(1.0 - keep**2) * noise[k]
    return TRACKER * noise


@pytest.mark.parametrize("keep", [0.3, 0.8])
def test_noise_that_lingers_longer_or_shorter_is_noise_too(keep: float) -> None:
    """By a cut in the size of the wander 0.6 of it counted as noise by luck, and 0.8 as something of no catalogue."""
    states = still()
    found = diagnosed(read_with(states, lingering(states, keep)))
    assert not found.unexplained
    assert found.reading.p_nothing > 0.95


def test_noise_that_lingers_from_reading_to_reading_is_noise() -> None:
    states = still()
    found = diagnosed(read_with(states, lingering(states, 0.6)))
    assert found.reading.p_nothing > 0.95
    assert found.after is not None
    # 8 runs of 25 readings of three components: 600 numbers tell a correlation to 0.03; lag five is not yet the end.
    assert found.after.lag_one_correlation == pytest.approx(0.6, abs=0.1)
    assert found.after.adequate
    assert not found.unexplained
    assert any("correlated errors" in warning for warning in diagnosis_result(found).warnings)


def test_a_target_that_wanders_off_is_not() -> None:
    states = still()
    walk = np.cumsum(np.random.default_rng(4).normal(size=(len(states), 3)), axis=0)
    noise = np.random.default_rng(5).normal(size=(len(states), 3))
    found = diagnosed(read_with(states, TRACKER * (noise + 0.4 * walk)))
    assert found.after is not None
    assert found.after.drifts
    assert found.unexplained


def test_a_run_noisier_than_the_others_is_doubted_holds_no_bumps_and_lacks_nothing() -> None:
    states = still()
    noise = TRACKER * np.random.default_rng(6).normal(size=(len(states), 3))
    noise[states.run == 2] *= 5.0
    noisy = reject_outliers(read_with(states, noise))
    assert noisy.used.all()
    found = diagnosed(noisy)
    assert dict(found.doubted) == {Off(2): pytest.approx(1.0, abs=1e-3)}
    assert not found.unexplained
    assert found.adequate
    bumped = noisy.position.copy()
    bumped[[30, 160], 0] += [[6e-4, 0.0, 0.0]]
    assert set(np.flatnonzero(~reject_outliers(replace(noisy, position=bumped)).used)) == {30, 160}


@pytest.mark.parametrize("spoilt", [False, True])
def test_a_stated_noise_too_small_is_said_and_a_structure_is_still_distinguished_from_it(spoilt: bool) -> None:
    states = still(cycles=1)
    noise = 1.5 * TRACKER * np.random.default_rng(8).normal(size=(len(states), 3))
    if spoilt:
        noise[:, 0] += 6.0 * TRACKER * (states.wrench[:, 2] / np.abs(states.wrench[:, 2]).max()) ** 2
    stated = replace(states.setup, sigma=Sigma(TRACKER, 3e-5, 1e-3, 1e-3))
    seen = replace(read_with(states, noise), setup=stated)
    found = diagnosed(seen)
    assert found.after is not None
    assert not found.after.adequate
    assert found.unexplained == spoilt
    diagnosis = diagnosis_result(found)
    assert ("sigma in campaign.toml" in " ".join(diagnosis.warnings)) == (not spoilt)
    assert ("larger than stated" in diagnosis.summary) == (not spoilt)
