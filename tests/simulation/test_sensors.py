"""Instruments: size and correlation of the noise, drift, steps, limits, knocks, clocks."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.simulation.played.cycles import load_program
from stiffcal.simulation.settings import Loads, Sensor
from stiffcal.simulation.written.sensors import (
    Channels,
    HoldErrors,
    clock_of,
    hold_errors,
    hold_errors_at,
    read_out,
    sample_times,
)

FORCE = Channels(("force_N",) * 3)


def streams() -> tuple[np.random.Generator, np.random.Generator]:
    return np.random.default_rng(1), np.random.default_rng(2)


def shown(truth: float = 0.0, size: int = 40000, hours: float = 0.0, **settings: object) -> np.ndarray:
    sensor = Sensor.model_validate({"rate_hz": 100.0, **settings})
    exact = np.full((size, 3), truth)
    return read_out(sensor, FORCE, exact, np.zeros_like(exact), np.full(size, hours), streams())


def test_without_settings_an_instrument_is_exact() -> None:
    assert (shown(3.25) == 3.25).all()


def test_white_noise_has_its_size_and_no_memory() -> None:
    noise = shown(white={"force_N": 1.5})
    assert np.std(noise, axis=0) == pytest.approx(np.full(3, 1.5), rel=0.02)
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 0.02


def test_a_table_averages_readings() -> None:
    exact = np.zeros((40000, 3))
    sensor = Sensor.model_validate({"white": {"force_N": 1.2}, "readings_per_hold": 6})
    noise = read_out(sensor, FORCE, exact, exact, np.zeros(40000), streams())
    assert np.std(noise) == pytest.approx(1.2 / np.sqrt(6), rel=0.02)


def test_drift_has_its_length_and_grows_with_time() -> None:
    one, two = (shown(size=1, hours=hours, drift_per_hour={"force_N": 2.0})[0] for hours in (1.0, 2.0))
    assert np.sqrt(np.sum(one**2)) == pytest.approx(2.0)
    assert two == pytest.approx(2 * one)


def test_resolution_and_saturation() -> None:
    steps = shown(0.37, resolution={"force_N": 0.25})
    assert (steps == 0.25).all()
    assert (shown(700.0, saturation={"force_N": 500.0}) == 500.0).all()
    assert (shown(-700.0, saturation={"force_N": 500.0}) == -500.0).all()


def test_noise_between_holds_lasts_for_a_hold() -> None:
    sensor = Sensor.model_validate({"rate_hz": 50.0, "between_holds": {"force_N": 2.0}})
    program = load_program(Loads(cycles=40), np.eye(3), np.random.default_rng(0))
    errors = hold_errors(sensor, FORCE, len(program), np.random.default_rng(4))
    assert np.std(errors.between) == pytest.approx(2.0, rel=0.05)
    time = np.array([0.1, 0.5, 0.9])[:, None] * (program.end - program.start) + program.start
    for moment in time:
        assert hold_errors_at(errors, program, moment, program.path(moment)) == pytest.approx(errors.between)


def test_a_knock_spoils_its_hold_alone() -> None:
    program = load_program(Loads(), np.eye(3), np.random.default_rng(0))
    sensor = Sensor.model_validate({"bumps": {"per_run": 2, "size": {"force_N": 30.0}}})
    errors = hold_errors(sensor, FORCE, len(program), np.random.default_rng(4))
    assert len(errors.disturbed_holds) == 2
    assert 0 not in errors.disturbed_holds
    middle = 0.5 * (program.start + program.end)
    size = np.sqrt(np.sum(hold_errors_at(errors, program, middle, program.path(middle)) ** 2, axis=1))
    assert np.flatnonzero(size > 0).tolist() == list(errors.disturbed_holds)
    assert size[list(errors.disturbed_holds)] == pytest.approx([30.0, 30.0])
    assert isinstance(errors, HoldErrors)


def test_clocks_restart_or_run_on() -> None:
    fast = Sensor.model_validate({"rate_hz": 10.0, "clock_drift_ppm": 100.0, "starts_before_s": [2.0, 2.0]})
    clock = clock_of(fast, 1000.0, np.random.default_rng(0))
    time = sample_times(fast, clock, 50.0)
    assert time[0] == -2.0
    assert clock.reading(time[:3]).tolist() == pytest.approx([0.0, 0.1, 0.2])
    assert clock.reading(np.array([98.0]))[0] == pytest.approx(100.0 * 1.0001)
    on = fast.model_copy(update={"clock": "runs on", "clock_ahead_s": 7.0})
    assert clock_of(on, 1000.0, np.random.default_rng(0)).reading(np.array([0.0]))[0] == pytest.approx(
        1000.0 * 1.0001 + 7
    )
