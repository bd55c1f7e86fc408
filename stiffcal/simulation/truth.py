"""`truth.json`: what a simulated campaign hides. Nothing but tests and benchmarks reads one.

Except for the words in a report's page on compensation that say what the simulated controller's delay is made of.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.documents import Document
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.low_pass import LowPass
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.simulation.settings import Amounts, Controller, Sensor
from stiffcal.simulation.written.recording import Device, DeviceLog, RecordingContext

TRUTH_FILE = "truth.json"
TRUTH_SCHEMA = "stiffcal/truth/1"


def truth_document(
    robot: CompliantRobot,
    recording: RecordingContext,
    devices_by_run: Sequence[Sequence[Device]],
    logs: Sequence[Sequence[DeviceLog]],
    controller: Controller | None = None,
) -> Document:
    """Return the document of truth.json.

    Parameters
    ----------
    robot : as simulated.
    recording : the simulated runs, frames and seed.
    devices_by_run, logs : for each run, the devices that record it and their logs.
    controller : that corrected in some of the runs; None: none did.

    Returns
    -------
    dict
        ``parameters`` by full name (SI); ``joint_stiffness`` by parameter name, N·m/rad; ``noise`` by source, per axis;
        ``frames`` as they really are (parent_from_frame); per run ``clock_ahead_s`` against the first source in the
        middle of the run, ``holds`` as [start, end] on the first source's clock, ``bumped`` holds from 1 by source.
        `simulate_campaign` adds ``written``, the SHA-256 of every other file that it writes, where it writes documents.
        With a controller that corrected, ``controller``: what makes its delay, s, and the effects that it holds.
    """
    corrected = {} if controller is None else {"controller": _delays(controller)}
    stiffness = {
        placed_effect.parameter_name(spec.symbol): 1.0 / placed_effect.values[spec.symbol]
        for placed_effect in robot.placed
        for spec in placed_effect.effect.parameters
        if spec.compliance and placed_effect.values[spec.symbol] > 0.0
    }
    return {
        "schema": TRUTH_SCHEMA,
        "warnings": [],
        "seed": recording.seed,
        "parameters": robot.values(),
        "joint_stiffness": stiffness,
        "noise": {device.name: _noise(device.sensor) for devices in devices_by_run for device in devices},
        "frames": {
            name: {"body": attached.body, "body_from_frame": np.round(attached.transform, 12).tolist()}
            for name, attached in recording.frames.items()
        },
        "runs": [
            _run(recording, robot.chain, devices, written)
            for devices, written in zip(devices_by_run, logs, strict=True)
        ],
        **corrected,
    }


def _delays(controller: Controller) -> Document:
    lag = 0.0 if controller.filter_hz is None else LowPass(controller.filter_hz, 1.0 / controller.cycle_s).delay_s
    return {
        "cycle_s": controller.cycle_s,
        "delay_s": controller.delay_s,
        "filter_lag_s": lag,
        "effects": controller.effects,
    }


def _noise(sensor: Sensor) -> dict[str, dict[str, float]]:
    """Return the scatter of a source's readings per axis, SI: within a hold and between holds."""
    parts: dict[str, Amounts] = {"white": sensor.white, "between_holds": sensor.between_holds}
    return {
        name: {key: value for key, value in amounts.model_dump().items() if value} for name, amounts in parts.items()
    }


def _run(recording: RecordingContext, chain: Chain, devices: Sequence[Device], logs: Sequence[DeviceLog]) -> Document:
    """Return the truth of one run: its entry in ``runs`` of `truth_document`."""
    true_run = recording.true_run[devices[0].run]
    program = true_run.planned.program
    middle = np.array([0.5 * program.duration])
    first = devices[0].clock
    # all devices record the first hold from the last one's start on, and the last hold until the first one stops
    over_time = [device for device in devices if not device.source.is_states]
    start, end = program.start.copy(), program.end.copy()
    if over_time:
        start[0] = max(device.clock.begin for device in over_time)
        end[-1] = min(device.stops for device in over_time)
    holds = np.stack([first.reading(start), first.reading(end)], axis=1)
    ahead = {device.name: float((device.clock.reading(middle) - first.reading(middle))[0]) for device in devices}
    return {
        "id": true_run.planned.name,
        "joints_deg": np.round(chain.printed_positions(true_run.planned.joints), 9).tolist(),
        "clock_ahead_s": {name: round(value, 6) for name, value in ahead.items()},
        "holds": np.round(holds, 4).tolist(),
        "load": np.round(program.wrench, 6).tolist(),
        "bumped": {
            device.name: [hold + 1 for hold in log.disturbed_holds]
            for device, log in zip(devices, logs, strict=True)
            if log.disturbed_holds
        },
    }
