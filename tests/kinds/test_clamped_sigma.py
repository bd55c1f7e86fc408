"""What a clamped state's own standard uncertainty is worth: residuals at the truth over it, over simulated seeds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from stiffcal.arrays import Floats
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.states.states import PIECES, _windows, clamped_states
from stiffcal.measurements.load_states import RunInfo

SEEDS = 10
STIFFNESS, REACH, PERIOD, RATE = 3e5, 1.05e-3, 8.0, 200.0
ANGLE_NOISE, TORQUE_NOISE = 4e-6, 0.36


def true_angle(time: Floats) -> Floats:
    """Return (n,) rad of a triangle to and fro: between its turns every stretch is a parabola exactly."""
    return np.asarray(
        REACH * np.interp(time % PERIOD, np.array([0.0, 0.25, 0.75, 1.0]) * PERIOD, [0.0, 1.0, -1.0, 0.0])
    )


def noise(rng: np.random.Generator, n: int, correlation: float) -> Floats:
    """Return (n,) of unit variance, each reading correlated with the one before."""
    fresh = np.sqrt(1.0 - correlation**2) * rng.standard_normal(n + 200)
    return np.asarray(lfilter([1.0], [1.0, -correlation], fresh)[200:])


def normalised(seed: int, correlation: float, step: float) -> tuple[Floats, Floats]:
    """Return residuals of the states' angles and moments at the truth over the sigma that the states carry."""
    rng = np.random.default_rng([23, seed])
    phase = rng.uniform(0.0, PERIOD)
    time = np.arange(0.0, 8.0 * PERIOD, 1.0 / RATE)
    angle = true_angle(time + phase)
    joints, wrench = np.zeros((time.size, 6)), np.zeros((time.size, 6))
    joints[:, 2] = angle + ANGLE_NOISE * noise(rng, time.size, correlation)
    if step:
        joints[:, 2] = step * np.round(joints[:, 2] / step)
    wrench[:, 5] = STIFFNESS * angle + TORQUE_NOISE * noise(rng, time.size, correlation)
    readings = ClampedReadings(
        (RunInfo("a", "clamped"),), np.zeros(time.size, dtype=np.int64), time, joints, wrench,
        np.full((time.size, 6), np.nan), np.array([False]),
    )  # fmt: skip
    states = clamped_states(readings, 3, wrench)
    assert states is not None
    true = true_angle(states.time + phase)
    # in the stretch that holds a turn the angle is no parabola
    inside = np.abs(true) < REACH - 2e-5
    of_angle = (states.signals["joints"][:, 2] - true) / states.signals["sigma.motor"][:, 0]
    of_moment = (states.signals["wrench"][:, 5] - STIFFNESS * true) / states.signals["sigma.wrench"][:, 5]
    return of_angle[inside], of_moment[inside]


def mean_squares(correlation: float, step: float, seeds: int = SEEDS) -> tuple[float, float, float]:
    """Return the mean square of both over all seeds, and the standard uncertainty that such means have."""
    both = [normalised(seed, correlation, step) for seed in range(seeds)]
    angles, moments = (np.concatenate([pair[k] for pair in both]) for k in range(2))
    # states share no readings: a mean of n squares of normal numbers scatters by √(2/n)
    return float(np.mean(angles**2)), float(np.mean(moments**2)), float(np.sqrt(2.0 / angles.size))


def test_white_noise_is_stated_as_it_is() -> None:
    of_angle, of_moment, error = mean_squares(0.0, 0.0)
    assert error < 0.02
    assert of_angle == pytest.approx(1.0, abs=3.0 * error)
    assert of_moment == pytest.approx(1.0, abs=3.0 * error)


@pytest.mark.parametrize(("steps_of_noise", "least"), [(1.5, 0.9), (5.0, 0.6)])
def test_an_encoders_step_is_never_stated_as_less_than_it_is(steps_of_noise: float, least: float) -> None:
    """Rounding counts in the scatter of neighbours and, as it does not average out, once more by itself.

    Where noise dithers it the states are therefore better than stated: mean squares of 0.95 with steps of 1.5 times the
    noise, 0.69 with five times.
    """
    of_angle, of_moment, error = mean_squares(0.0, steps_of_noise * ANGLE_NOISE)
    assert least < of_angle < 1.0 + 3.0 * error
    assert of_moment == pytest.approx(1.0, abs=3.0 * error)


@pytest.mark.parametrize("correlation", [0.3, 0.6, pytest.param(0.8, marks=pytest.mark.long)])
def test_correlated_noise_is_stated_as_it_is(correlation: float) -> None:
    of_angle, of_moment, error = mean_squares(correlation, 0.0, seeds=4)
    # the correlation itself is estimated: a tenth of the variance for that
    assert of_angle == pytest.approx(1.0, abs=0.1 + 3.0 * error)
    assert of_moment == pytest.approx(1.0, abs=0.1 + 3.0 * error)


@pytest.mark.parametrize("cutoff", [pytest.param(20.0, marks=pytest.mark.long), 40.0])
def test_filtered_noise_is_stated_as_it_is(cutoff: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A low-pass filter of second order in the instrument, cutoff in Hz of a log of 200 readings a second."""
    b, a = butter(2, cutoff / (0.5 * RATE))

    def filtered(rng: np.random.Generator, n: int, correlation: float) -> Floats:
        series = lfilter(b, a, rng.standard_normal(n + 400))[400:]
        # its response to white noise, summed over an impulse
        return np.asarray(series / np.sqrt(np.sum(lfilter(b, a, np.eye(1, 400)[0]) ** 2)))

    monkeypatch.setitem(globals(), "noise", filtered)
    of_angle, of_moment, error = mean_squares(0.0, 0.0, seeds=4)
    assert of_angle == pytest.approx(1.0, abs=0.1 + 3.0 * error)
    assert of_moment == pytest.approx(1.0, abs=0.1 + 3.0 * error)


def test_what_repeats_with_the_cycle_is_no_noise() -> None:
    """A ripple in the torque of four readings' noise, as gears make one, is the same in each cycle: it is signal."""
    rng = np.random.default_rng(5)
    # 8 half sweeps of 800 readings, a ripple of 40 readings' length
    signal = 4.0 * np.sin(2.0 * np.pi * np.arange(800) / 40.0)
    values = np.tile(np.concatenate([signal, signal[::-1]]), 4) + rng.standard_normal(6400)
    time, edges = np.arange(6400) / RATE, list(range(0, 6401, 800))
    windows = _windows(time, np.stack([values, values], axis=1), edges)
    series = windows.noise(values)
    # of 6400 readings the standard deviation is known to 1/√12800 = 0.9 %
    assert series.sigma == pytest.approx(1.0, abs=0.03)
    assert series.inflation == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("correlation", "pieces"), [(0.0, max(PIECES)), (0.95, min(PIECES))])
def test_noise_correlated_over_a_whole_window_is_looked_at_in_longer_ones(correlation: float, pieces: int) -> None:
    """A correlation of 0.95 inflates means 39 times: of 25 readings, states are stated 1.6 times as good as they are.

    That is what `mean_squares(0.95, 0.0)` shows; the longest windows hold 100 readings.
    """
    time, edges = np.arange(6400) / RATE, list(range(0, 6401, 800))
    values = noise(np.random.default_rng(5), 6400, correlation)
    assert _windows(time, np.stack([values, values], axis=1), edges).pieces == pieces
