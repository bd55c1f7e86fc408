"""From played runs to each device's columns: samples on its own clock, errors, the lab's units."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.source import Source, TimeAxis
from stiffcal.campaign.signals.signals import Pose
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment
from stiffcal.quantities import unit
from stiffcal.simulation.played.true_motion import TrueRun
from stiffcal.simulation.settings import FILE_NAME, Sensor, SimulationSettings
from stiffcal.simulation.written.instruments import (
    SamplingContext,
    SignalSamples,
    as_columns,
    decimals_of,
    true_reading,
)
from stiffcal.simulation.written.logs import Column
from stiffcal.simulation.written.markers import draw_hidden_markers, without_hidden
from stiffcal.simulation.written.sensors import (
    Clock,
    clock_of,
    hold_errors,
    hold_errors_at,
    read_out,
    sample_times,
)

# When simulated clocks that write dates say that the campaign starts.
EPOCH = datetime(2026, 1, 12, 8, 0, 0, tzinfo=UTC)
# A device is stopped this long after the last hold, s.
STOPS_AFTER = (0.2, 0.8)


class Stream(IntEnum):
    """What random numbers are for; each use has a stream of its own, so that adding one changes no other."""

    LOADS = 0
    CLOCK = 1
    HOLDS = 2
    NOISE = 3
    DRIFT = 4
    MISPLACED = 5
    ZERO = 6
    HIDDEN = 7
    GEOMETRY = 8


def stream(seed: int, use: Stream, *place: int) -> np.random.Generator:
    """Return the random numbers for one use at one place (run, source, signal)."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(use), *place)))


@dataclass(frozen=True)
class RecordingContext:
    """What all recordings of a campaign share."""

    settings: SimulationSettings
    """`simulate.toml`."""
    frames: Mapping[str, Attachment]
    """The true frames by name."""
    true_run: tuple[TrueRun, ...]
    """The runs."""
    seed: int
    """Of the campaign."""
    gear_ratio: Floats
    """(L,) motor turns per joint turn."""

    rods: Mapping[str, tuple[int, Floats]] = field(default_factory=dict)
    """Rod to its link's node, and what it reads, (7,): of that node's displacement, and per kelvin."""
    metres_of_rods: Mapping[str, float] = field(default_factory=dict)
    """Metres of a unit of each rod's reading."""

    def misplaced(self, run: int) -> Floats:
        """Return (6,) the error of the robot's pose in a run, beyond its kinematics, m and rad, base axes."""
        robot = self.settings.robot
        samples = stream(self.seed, Stream.MISPLACED, run).standard_normal(6)
        size = np.repeat([robot.position_error_m, robot.orientation_error_rad], 3)
        return np.asarray(size * samples)


@dataclass(frozen=True)
class Device:
    """One source of the manifest in one run."""

    name: str
    """The source's name."""
    number: int
    """Its position in the manifest."""
    source: Source
    """The source's table of the manifest."""
    sensor: Sensor
    """Its simulated errors."""
    run: int
    """Number of the run."""
    run_name: str
    """The run's id."""
    clock: Clock
    """Its clock in this run."""
    stops: float
    """s, true time from the run's first hold when the log ends."""

    @property
    def place(self) -> str:
        """How to call the source in a fault."""
        return f"sources.{self.name}"


@dataclass(frozen=True)
class DeviceLog:
    """What one device wrote in one run."""

    columns: Mapping[str, Column]
    """Column name to n numbers in the lab's units, or words."""
    decimals: Mapping[str, int]
    """Column name to decimals in text logs."""
    units: Mapping[str, str]
    """Column name to unit."""
    disturbed_holds: tuple[int, ...]
    """Numbers of the holds spoilt by a knock, from 0."""


def devices_of(
    recording: RecordingContext,
    sources: Mapping[str, Source],
    run: int,
    logs_run: Callable[[str], bool] = lambda _: True,
) -> list[Device]:
    """Switch on the devices for one run, each at its own moment with its own clock.

    Parameters
    ----------
    logs_run : whether a source, by its name, logs this run: a device for another direction stands idle.

    Raises
    ------
    InputError
        a log over time has no rate.
    """
    devices = []
    true_run = recording.true_run[run]
    for number, (name, source) in enumerate(sources.items()):
        if not logs_run(name):
            continue
        sensor = recording.settings.sensor(name)
        axis_rate = source.time.rate_hz if source.time is not None else None
        if source.is_states:
            sensor = sensor.model_copy(update={"rate_hz": None})
        elif axis_rate is not None:
            sensor = sensor.model_copy(update={"rate_hz": axis_rate})
        elif sensor.rate_hz is None:
            place = f"sensors.{name}.rate_hz"
            raise InputError.at(
                FaultCode.KEY_MISSING, FILE_NAME, place, "a log over time needs a rate", "add it, e.g. rate_hz = 50.0"
            )
        rng = stream(recording.seed, Stream.CLOCK, run, number)
        clock = clock_of(sensor, true_run.planned.start_s, rng)
        stops = true_run.planned.program.duration + float(rng.uniform(*STOPS_AFTER))
        devices.append(Device(name, number, source, sensor, run, true_run.planned.name, clock, stops))
    return devices


def record(recording: RecordingContext, device: Device) -> DeviceLog:
    """Return one device's log of one run.

    Raises
    ------
    InputError
        a signal is of a kind that is not simulated.
    """
    true_run = recording.true_run[device.run]
    program = true_run.planned.program
    kept_rows = None
    if device.source.is_states:
        time = 0.5 * (program.start + program.end)
        if device.source.run is not None and device.source.run.each == "row":
            kept_rows = np.flatnonzero(program.level > 0.0)
    else:
        time = sample_times(device.sensor, device.clock, device.stops)
    samples = SamplingContext(
        true_run, time, program.path(time), recording.frames, recording.settings.robot, recording.misplaced(device.run),
        recording.gear_ratio, recording.rods,
    )  # fmt: skip
    columns: dict[str, Column] = {}
    decimals: dict[str, int] = {}
    units: dict[str, str] = {}
    disturbed_holds: set[int] = set()
    if device.source.run is not None and device.source.run.column is not None:
        columns[device.source.run.column] = [true_run.planned.name] * time.size
    if device.source.time is not None and device.source.time.column is not None:
        column, places = _time_column(device.source.time, device.clock.reading(time))
        columns[device.source.time.column], decimals[device.source.time.column] = column, places
        units[device.source.time.column] = device.source.time.unit or "s"
        # the whole time is in its column
        columns |= {name: np.zeros(time.size) for name in device.source.time.columns[1:]}
    for number, (name, signal) in enumerate(device.source.signals().items()):
        truth = true_reading(signal, samples, f"{device.place}.{name}")
        reading, disturbed_holds_of_signal = _with_errors(recording, device, number, truth, samples)
        if name == "deflection":
            # the unloaded reading, which was taken off, errs like all others
            reading = replace(reading, value=reading.value - (reading.value[:1] - truth.value[:1]))
        columns.update(as_columns(signal, reading, recording.metres_of_rods))
        decimals.update(decimals_of(signal))
        units.update({key: value.name for key, value in signal.columns_with_units().items()})
        disturbed_holds.update(disturbed_holds_of_signal)
    decimals.update(device.sensor.decimals)
    if kept_rows is not None:
        columns = {name: _rows(column, kept_rows) for name, column in columns.items()}
    return DeviceLog(columns, decimals, units, tuple(sorted(disturbed_holds)))


def _rows(column: Column, rows: NDArray[np.int64]) -> Column:
    """Return some rows of a column."""
    return column[rows] if isinstance(column, np.ndarray) else [column[row] for row in rows]


def _with_errors(
    recording: RecordingContext, device: Device, signal: int, truth: SignalSamples, samples: SamplingContext
) -> tuple[SignalSamples, tuple[int, ...]]:
    """Return a signal with its errors, and the holds that a knock has spoilt."""
    program = samples.true_run.planned.program
    place = (device.run, device.number, signal)
    errors = hold_errors(device.sensor, truth.channels, len(program), stream(recording.seed, Stream.HOLDS, *place))
    lasting = hold_errors_at(errors, program, samples.time, samples.path)
    streams = (
        stream(recording.seed, Stream.NOISE, *place),
        stream(recording.seed, Stream.DRIFT, device.number, signal),
    )
    zero = stream(recording.seed, Stream.ZERO, *place)
    value = read_out(device.sensor, truth.channels, truth.value, lasting, samples.hours, streams, zero)
    if device.sensor.starts_anew:
        angles = np.array([quantity == "angle_rad" for quantity in truth.channels.quantity])
        value = np.where(angles, (value + np.pi) % (2.0 * np.pi) - np.pi, value)
    quantity = list(device.source.signals().values())[signal]
    if isinstance(quantity, Pose) and quantity.markers and device.sensor.hidden:
        rng = stream(recording.seed, Stream.HIDDEN, *place)
        hidden = draw_hidden_markers(device.sensor.hidden, len(quantity.markers), len(program), rng)
        value = without_hidden(value, hidden, program.hold_at(samples.time))
    return replace(truth, value=value), errors.disturbed_holds


def _time_column(axis: TimeAxis, clock_time: Floats) -> tuple[Column, int]:
    """Return a time column in the manifest's unit, and its decimals in text logs."""
    if axis.in_words:
        moments = [EPOCH + timedelta(seconds=float(value)) for value in clock_time]
        return [moment.isoformat(timespec="microseconds").replace("+00:00", "Z") for moment in moments], 0
    factor = unit(axis.unit or "s", "time").factor
    # a microsecond, as loggers do: a hundredth of what clocks can be aligned to
    return clock_time / factor, max(0, round(6 + np.log10(factor)))
