"""Instruments: what they make of the truth (noise, drift, steps, knocks), and the clocks they log with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.simulation.played.cycles import LoadProgram, interpolate_between_holds
from stiffcal.simulation.settings import Amounts, Sensor

# What single components of a signal are, so that the amounts of the settings find their columns.
QUANTITIES = (
    "force_N", "moment_Nm", "translation_m", "rotation_rad", "angle_rad", "temperature_K", "velocity_rad_s",
    "torque_Nm", "current_A",
)  # fmt: skip


@dataclass(frozen=True)
class Channels:
    """Groups of columns that are three components of one thing, or independent readings."""

    quantity: tuple[str, ...]
    """One of `QUANTITIES` for each column; any other word for what has no error."""

    def amount(self, amounts: Amounts) -> Floats:
        """Return (c,) the amount of each column."""
        return np.array([getattr(amounts, name, 0.0) for name in self.quantity], dtype=np.float64)

    def along_random_direction(self, amounts: Amounts, rng: np.random.Generator) -> Floats:
        """Return (c,) errors whose length in each quantity is the amount, in a direction that is drawn."""
        result = rng.standard_normal(len(self.quantity))
        names = np.array(self.quantity)
        for name in dict.fromkeys(self.quantity):
            members = names == name
            result[members] *= getattr(amounts, name, 0.0) / np.sqrt(np.sum(result[members] ** 2))
        return np.asarray(result)


@dataclass(frozen=True)
class Clock:
    """A device's clock in one run: shown = ahead + (true − begin) (1 + drift)."""

    begin: float
    """s, true time from the run's start when the log begins."""
    shown_at_begin: float
    """s, what the clock shows then."""
    drift: float
    """Relative, positive where the clock runs fast."""

    def reading(self, true_time: Floats) -> Floats:
        """Return the clock's readings, s, at true times from the run's start, s."""
        return np.asarray(self.shown_at_begin + (true_time - self.begin) * (1.0 + self.drift))


def clock_of(sensor: Sensor, run_begins: float, rng: np.random.Generator) -> Clock:
    """Draw when a device's log begins and what its clock shows then.

    Parameters
    ----------
    sensor : the settings.
    run_begins : s, true time of the run's first hold on the campaign's clock.
    rng : draws how long before the first hold the log begins.
    """
    low, high = sensor.starts_before_s
    begin = -float(rng.uniform(low, high))
    drift = sensor.clock_drift_ppm * 1e-6
    if sensor.clock == "restarts":
        return Clock(begin, 0.0, drift)
    return Clock(begin, (run_begins + begin) * (1.0 + drift) + sensor.clock_ahead_s, drift)


def sample_times(sensor: Sensor, clock: Clock, until: float) -> Floats:
    """Return (n,) true times from the run's start, s, at which a device samples: regular on its own clock."""
    if sensor.rate_hz is None:
        raise ValueError("a log over time needs rate_hz")
    true_period = 1.0 / (sensor.rate_hz * (1.0 + clock.drift))
    count = int((until - clock.begin) / true_period) + 1
    return np.asarray(clock.begin + true_period * np.arange(count))


@dataclass(frozen=True)
class HoldErrors:
    """Errors of one signal that last for a hold."""

    between: Floats
    """(m, c) drawn anew for each hold."""
    disturbed_holds: tuple[int, ...]
    """Numbers of the holds that a knock has spoilt, from 0."""
    bump: Floats
    """(m, c) the error in those."""


def hold_errors(sensor: Sensor, channels: Channels, n_holds: int, rng: np.random.Generator) -> HoldErrors:
    """Draw the errors of one signal in the holds of one run."""
    between = channels.amount(sensor.between_holds) * rng.standard_normal((n_holds, len(channels.quantity)))
    bump = np.zeros_like(between)
    # the reference, hold 0, is not picked: a spoilt reference is another fault than a spoilt reading
    count = min(sensor.bumps.per_run, n_holds - 1)
    disturbed_holds = (
        np.sort(rng.choice(np.arange(1, n_holds), size=count, replace=False)) if count else np.zeros(0, np.int64)
    )
    for hold in disturbed_holds:
        bump[hold] = channels.along_random_direction(sensor.bumps.size, rng)
    return HoldErrors(between, tuple(int(hold) for hold in disturbed_holds), bump)


def hold_errors_at(errors: HoldErrors, program: LoadProgram, time: Floats, path: Floats) -> Floats:
    """Return (n, c) the errors at sample times: in ramps they go over from one hold's to the next.

    A knock lasts from the middle of the ramp before the hold to the middle of the ramp after it.
    """
    hold = np.clip(np.rint((path - 0.5) / 2.0).astype(np.int64), 0, len(program) - 1)
    return interpolate_between_holds(errors.between, path) + errors.bump[hold]


def read_out(
    sensor: Sensor,
    channels: Channels,
    truth: Floats,
    lasting_error: Floats,
    hours: Floats,
    streams: tuple[np.random.Generator, np.random.Generator],
    zero: np.random.Generator | None = None,
) -> Floats:
    """Return (n, c) an instrument's readings.

    Parameters
    ----------
    sensor : how it errs.
    channels : the columns' quantities.
    truth : (n, c) SI.
    lasting_error : (n, c) errors that last for a hold.
    hours : (n,) since the campaign's start, for drift.
    streams : random numbers for this log's white noise, and for the drift's direction (the same in all runs).
    zero : random numbers for the zero error that is set at the run's start; None: no zero error.
    """
    noise, campaign = streams
    readings = max(sensor.readings_per_hold if sensor.rate_hz is None else 1, 1)
    white = channels.amount(sensor.white) / np.sqrt(readings)
    reading = truth + lasting_error + white * noise.standard_normal(truth.shape)
    reading = reading + hours[:, None] * channels.along_random_direction(sensor.drift_per_hour, campaign)
    if zero is not None:
        reading = reading + channels.amount(sensor.zero) * zero.standard_normal(truth.shape[1])
    limit = channels.amount(sensor.saturation)
    reading = np.where(limit > 0.0, np.clip(reading, -limit, limit), reading)
    step = channels.amount(sensor.resolution)
    return np.asarray(np.where(step > 0.0, np.round(reading / np.where(step > 0.0, step, 1.0)) * step, reading))
