"""Clamped runs as load states: what a stretch of a sweep is read as."""

from __future__ import annotations

import numpy as np

from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.states.states import clamped_states
from stiffcal.measurements.load_states import RunInfo

STIFFNESS, WIDTH, BAND = 3e5, 6e-4, 4.0


def driven(noise: float = 0.0) -> ClampedReadings:
    """Return a joint with play driven to and fro, four cycles, 80 readings a second; torque read as a moment."""
    time = np.arange(0.0, 34.0, 1.0 / 80.0)
    angle = 1.05e-3 * np.interp((time - 1.0) % 8.0, [0, 2, 6, 8], [0, 1, -1, 0]) * ((time > 1.0) & (time < 33.0))
    torque = np.linspace(-400.0, 400.0, 200001)
    give = torque / STIFFNESS + 0.5 * WIDTH * np.tanh(torque / BAND)
    moment = np.interp(angle, give, torque)
    joints = np.zeros((time.size, 6))
    joints[:, 2] = -angle + noise * np.random.default_rng(1).standard_normal(time.size)
    wrench = np.zeros((time.size, 6))
    wrench[:, 5] = moment
    return ClampedReadings(
        (RunInfo("a", "clamped"),), np.zeros(time.size, dtype=np.int64), time, joints, wrench,
        np.full((time.size, 6), np.nan), np.array([False]),
    )  # fmt: skip


def test_the_corner_between_play_and_flank_stays_sharp() -> None:
    """A mean over a stretch would lie off the law where it bends: by a third of a tenth of the play."""
    states = clamped_states(driven(), 3, driven().wrench)
    assert states is not None
    moment = states.signals["wrench"][:, 5]
    law = moment / STIFFNESS + 0.5 * WIDTH * np.tanh(moment / BAND)
    away = -states.signals["joints"][:, 2] - law
    # a stretch is 44 µrad long; what is left of its bend is below a hundredth of it, as a mean's would not be
    bent = (np.abs(moment) > BAND) & (np.abs(moment) < 5.0 * BAND)
    assert bent.sum() > 20
    assert np.sqrt(np.mean(away[bent] ** 2)) < 0.9e-6


def test_where_the_curve_bends_the_states_have_no_bias() -> None:
    """At the shoulders of the play, eight logs: their mean deviation from the law is that of their noise."""
    noise_angle, noise_moment = 3e-6, 0.05
    deviations = []
    for seed in range(8):
        readings = driven()
        draw = np.random.default_rng(seed)
        readings.joints[:, 2] += noise_angle * draw.standard_normal(len(readings))
        readings.wrench[:, 5] += noise_moment * draw.standard_normal(len(readings))
        states = clamped_states(readings, 3, readings.wrench)
        assert states is not None
        moment = states.signals["wrench"][:, 5]
        law = moment / STIFFNESS + 0.5 * WIDTH * np.tanh(moment / BAND)
        slope = 1.0 / STIFFNESS + 0.5 * WIDTH / BAND / np.cosh(moment / BAND) ** 2
        std = np.hypot(states.signals["sigma.motor"][:, 0], slope * states.signals["sigma.wrench"][:, 5])
        bent = (np.abs(moment) > BAND) & (np.abs(moment) < 3.0 * BAND)
        deviations.append(((-states.signals["joints"][:, 2] - law) / std * np.sign(moment))[bent])
    outward = np.concatenate(deviations)
    assert outward.size > 100
    assert abs(outward.mean()) < 0.3


def test_noise_does_not_choose_the_ends() -> None:
    """The corners of the loop are the readings that noise drove out furthest: states stay off them."""
    noise = 2e-5
    states = clamped_states(driven(noise), 3, driven(noise).wrench)
    assert states is not None
    moment = states.signals["wrench"][:, 5]
    law = moment / STIFFNESS + 0.5 * WIDTH * np.tanh(moment / BAND)
    away = np.abs(moment)[1:] > 200.0
    out = (-states.signals["joints"][1:, 2] - law[1:]) * np.sign(moment[1:])
    assert abs(out[away].mean()) < 4.0 * noise / np.sqrt(away.sum())
