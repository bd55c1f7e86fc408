"""What each signal of the manifest would show without any error, and how a disturbed reading becomes its columns.

A signal passes through here twice: `true_reading` turns the played robot into natural components in SI (force and
moment, position and small turn), `sensors.read_out` spoils those, and `as_columns` writes them in the lab's columns and
units.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.signals.signals import (
    DeadWeight,
    Deflection,
    Displacement,
    Hold,
    JointSignals,
    Lengths,
    Pose,
    Signal,
    Temperature,
    Wrench,
)
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.rotations import rotation_from_vector, rpy_from_rotation, vector_from_rotation
from stiffcal.quaternions import quaternion_from_rotation
from stiffcal.reduction.states.approach import last_motion
from stiffcal.simulation.played.motion import MotionProgram, PoseProgram
from stiffcal.simulation.played.true_motion import TrueRun
from stiffcal.simulation.settings import TrueRobot
from stiffcal.simulation.written.sensors import Channels

# Decimals that text logs are written with: a digit finer than these steps (SI) adds nothing to any instrument.
_WRITTEN_STEP = {
    "strain": 1e-8,
    "mass": 1e-6, "length": 1e-8, "position": 1e-8, "translation": 1e-8, "angle": 1e-8, "rotation": 1e-8, "force": 1e-4,
    "moment": 1e-4, "torque": 1e-6, "temperature": 1e-3, "time": 1e-6, "velocity": 1e-8, "current": 1e-6,
}  # fmt: skip
_QUATERNION_DECIMALS = 9


@dataclass(frozen=True)
class SamplingContext:
    """When one device reads in one run, and where the run is then."""

    true_run: TrueRun
    """The run as it really was."""
    time: Floats
    """(n,) s, true, from the run's first hold."""
    path: Floats
    """(n,) path coordinates."""
    frames: Mapping[str, Attachment]
    """The true frames by name."""
    robot: TrueRobot
    """What the robot has beyond its files."""
    misplaced: Floats
    """(6,) m and rad, base axes: the error of the robot's pose beyond its kinematics, constant in the run."""
    gear_ratio: Floats
    """(L,) motor turns per joint turn."""

    rods: Mapping[str, tuple[int, Floats]] = field(default_factory=dict)
    """Rod to its link's node, and what it reads, (7,): of that node's displacement, and per kelvin."""

    @property
    def hours(self) -> Floats:
        """(n,) hours since the campaign's start."""
        return np.asarray((self.true_run.planned.start_s + self.time) / 3600.0)

    def place(self, frame: str) -> tuple[Floats, Floats]:
        """Return (n, 3) position and (n, 3, 3) rotation of a frame in base axes, as it really is."""
        position = self.true_run.position_at(frame, self.path)
        rotation = self.true_run.rotation_at(frame, self.path)
        if self.frames[frame].body == 0:
            return position, rotation
        shift = self._correction(frame)
        if shift is not None:
            position, rotation = position + shift[:, :3], rotation_from_vector(shift[:, 3:]) @ rotation
        return position + self.misplaced[:3], np.asarray(rotation_from_vector(self.misplaced[3:]) @ rotation)

    def stand(self, frame: str) -> tuple[Floats, Floats]:
        """Return the same of the frame that an instrument measures from: off the robot it stands on the ground.

        What makes the target wander, or the robot's base give, leaves the tracker where it is: else none would show.
        """
        attached = self.frames[frame]
        if attached.body != 0:
            return self.place(frame)
        n = self.time.size
        return np.tile(attached.transform[:3, 3], (n, 1)), np.tile(attached.transform[:3, :3], (n, 1, 1))

    def since_reference(self, frame: str) -> Floats:
        """Return (n, 6) displacement since the run's first hold: position, rotation vector of R R_refᵀ; base axes."""
        start = self.true_run.unloaded[frame]
        rotation = self.true_run.rotation_at(frame, self.path)
        translation = self.true_run.position_at(frame, self.path) - start[:3, 3]
        shift = self._correction(frame)
        if shift is not None:
            translation, rotation = translation + shift[:, :3], rotation_from_vector(shift[:, 3:]) @ rotation
        return np.concatenate([translation, vector_from_rotation(rotation @ start[:3, :3].T)], axis=1)

    def _correction(self, frame: str) -> Floats | None:
        """Return (n, 6) how far a correcting controller moves and turns a frame; None where none corrects."""
        correction = self.true_run.correction
        return None if correction is None else correction.shift_at(frame, self.time)


@dataclass(frozen=True)
class SignalSamples:
    """One signal at n samples."""

    channels: Channels
    """What the components are."""
    value: Floats
    """(n, c) SI."""
    rotation: Floats | None = None
    """(n, 3, 3) for poses with orientation: what the last three components are a small turn from, in the instrument's
    axes; else None.
    """


def frames_measured_by(signal: Signal) -> tuple[str, ...]:
    """Return the frames whose places a signal depends on."""
    if isinstance(signal, Wrench):
        return tuple(name for name in (signal.axes_frame, signal.point_frame) if name is not None)
    if isinstance(signal, Pose):
        lone = tuple(name for name, marker in signal.markers.items() if marker.at_m is None)
        return (signal.frame, signal.body or "target", *lone)
    if isinstance(signal, Deflection | Displacement):
        return (signal.axes, signal.body)
    return ()


def true_reading(signal: Signal, samples: SamplingContext, place: str) -> SignalSamples:
    """Return a signal's values without any error.

    Parameters
    ----------
    signal : from the manifest.
    samples : when it is read.
    place : how to call the signal in a fault.

    Raises
    ------
    InputError
        the signal is of a kind that is not simulated.
    """
    size = samples.time.size
    if isinstance(signal, Wrench):
        return _wrench(signal, samples)
    if isinstance(signal, Pose):
        return _pose(signal, samples) if signal.position is not None else _markers(signal, samples)
    if isinstance(signal, JointSignals):
        return _joints(signal, samples, place)
    if isinstance(signal, Deflection):
        axes = samples.stand(signal.axes)[1]
        motion = samples.since_reference(signal.body).reshape(size, 2, 3)
        turned = np.einsum("nji,nkj->nki", axes, motion).reshape(size, 6)
        if signal.rotation is None:
            return SignalSamples(Channels(("translation_m",) * 3), turned[:, :3])
        return SignalSamples(Channels(("translation_m",) * 3 + ("rotation_rad",) * 3), turned)
    if isinstance(signal, Displacement):
        along = np.array(signal.direction) / np.sqrt(np.sum(np.square(signal.direction)))
        direction = samples.stand(signal.axes)[1] @ along
        motion = samples.since_reference(signal.body)[:, :3]
        return SignalSamples(Channels(("translation_m",)), np.sum(direction * motion, axis=1)[:, None])
    if isinstance(signal, Lengths):
        return _lengths(signal, samples, place)
    if isinstance(signal, Temperature):
        kelvin = 273.15 + samples.robot.temperature_C + samples.robot.warming_K_per_hour * samples.hours
        count = len(signal.columns)
        return SignalSamples(Channels(("temperature_K",) * count), np.repeat(kelvin[:, None], count, axis=1))
    if isinstance(signal, Hold):
        program = samples.true_run.planned.program
        start = program.start[program.hold_at(samples.time)]
        return SignalSamples(Channels(("none",)), np.maximum(samples.time - start, 0.0)[:, None])
    program = samples.true_run.planned.program
    if isinstance(signal, DeadWeight) and isinstance(program, PoseProgram):
        return SignalSamples(Channels(("none",)), program.payload_at(samples.path)[:, None])
    raise InputError.at(
        FaultCode.SIMULATION_UNSUPPORTED,
        "campaign.toml",
        place,
        "this kind of signal cannot be simulated",
        "remove it from the folder given to --from",
    )


def _lengths(signal: Lengths, samples: SamplingContext, place: str) -> SignalSamples:
    """Changes of rods, of what the displacement of their link's end does to them, and of their getting warmer."""
    lengths = []
    for name in signal.columns:
        node, row = samples.rods[name]
        displacement = samples.true_run.node_at(node, samples.path)
        if displacement is None:
            raise InputError.at(
                FaultCode.SIMULATION_UNSUPPORTED,
                "campaign.toml", place, "the simulated robot does not return the bending of its links",
                "remove the rods, or use the equilibrium of stiffcal",
            )  # fmt: skip
        lengths.append(displacement @ row[:6] + row[6] * samples.robot.warming_K_per_hour * samples.hours)
    return SignalSamples(Channels(("length_m",) * len(lengths)), np.stack(lengths, axis=1))


def _wrench(signal: Wrench, samples: SamplingContext) -> SignalSamples:
    """Force and moment as the sensor's axes and origin see them, both moved along with the robot."""
    true_run = samples.true_run
    load = true_run.wrench_at(samples.path)
    axes = samples.stand(signal.axes_frame or "base")[1]
    point = samples.place(signal.point_frame or true_run.planned.loads.point)[0]
    acts_at = samples.place(true_run.planned.loads.point)[0]
    moment = load[:, 3:] + np.cross(acts_at - point, load[:, :3])
    force = np.einsum("nji,nj->ni", axes, load[:, :3])
    sign = 1.0 if signal.acts_on == "robot" else -1.0
    if len(signal.columns) == 1:
        along = np.array(signal.direction or (1.0, 0.0, 0.0))
        return SignalSamples(Channels(("force_N",)), sign * force @ (along / np.sqrt(along @ along))[:, None])
    if not signal.moments_measured:
        return SignalSamples(Channels(("force_N",) * 3), sign * force)
    turned = np.einsum("nji,nj->ni", axes, moment)
    return SignalSamples(
        Channels(("force_N",) * 3 + ("moment_Nm",) * 3), sign * np.concatenate([force, turned], axis=1)
    )


def _markers(signal: Pose, samples: SamplingContext) -> SignalSamples:
    """Places of a body's markers in the instrument's own axes, (n, 3 m), in the manifest's order."""
    origin, axes = samples.stand(signal.frame)
    position, rotation = samples.place(signal.body or "target")
    marker_places = []
    for name, marker in signal.markers.items():
        marker_place = samples.place(name)[0] if marker.at_m is None else position + rotation @ np.array(marker.at_m)
        marker_places.append(np.einsum("nji,nj->ni", axes, marker_place - origin))
    return SignalSamples(Channels(("translation_m",) * (3 * len(marker_places))), np.concatenate(marker_places, axis=1))


def _pose(signal: Pose, samples: SamplingContext) -> SignalSamples:
    """Place of the body in the instrument's own axes."""
    origin, axes = samples.stand(signal.frame)
    position, rotation = samples.place(signal.body or "target")
    place = np.einsum("nji,nj->ni", axes, position - origin)
    if signal.orientation is None:
        return SignalSamples(Channels(("translation_m",) * 3), place)
    value = np.concatenate([place, np.zeros_like(place)], axis=1)
    turned = np.asarray(np.swapaxes(axes, 1, 2) @ rotation)
    return SignalSamples(Channels(("translation_m",) * 3 + ("rotation_rad",) * 3), value, turned)


def _joints(signal: JointSignals, samples: SamplingContext, place: str) -> SignalSamples:
    """What the controller shows: held motors stand where they are, driven ones where they are driven.

    Motor-side logs carry motor angles, velocities and torques; currents are torques over the torque constant.
    """
    program, n = samples.true_run.planned.program, samples.time.size
    driven = isinstance(program, MotionProgram)
    if not driven and set(signal.groups()) - {"position", "command"}:
        reason = "velocities, torques and currents are simulated only for driven motors (clamped, friction)"
        raise InputError.at(
            FaultCode.SIMULATION_UNSUPPORTED,
            "campaign.toml",
            place,
            reason,
            "remove these columns, or use a separate source for such runs",
        )
    ratio = samples.gear_ratio if signal.motor else np.ones_like(samples.gear_ratio)
    parts, kinds = [], []
    for key in signal.groups():
        if not isinstance(program, MotionProgram):
            value, kind = np.repeat(samples.true_run.planned.joints[None, :], n, axis=0), "angle_rad"
            if samples.true_run.correction is not None:
                value = value + samples.true_run.correction.offset_at(samples.time)
            value = value * ratio
        elif key in ("position", "command"):
            value, kind = program.joints_at(samples.path) * ratio, "angle_rad" if key == "position" else "none"
        elif key == "approach":
            # a motor whose ratio is negative turned the other way
            value, kind = _last_motions(program, samples.path) * np.sign(ratio), "none"
        elif key == "velocity":
            value, kind = program.velocity_at(samples.path) * ratio, "velocity_rad_s"
        else:
            value, kind = program.torque_at(samples.path) / ratio, "torque_Nm"
            if key == "current":
                value, kind = value / _torque_constants(signal, place, value.shape[1]), "current_A"
        parts.append(value)
        kinds += [kind] * value.shape[1]
    return SignalSamples(Channels(tuple(kinds)), np.concatenate(parts, axis=1))


def _last_motions(program: MotionProgram, path: Floats) -> Floats:
    """Return (n, L) the sign of the last motion of each logged joint before poses taken one after the other."""
    if not isinstance(program, PoseProgram):
        return np.zeros((path.size, program.joints.shape[1]))
    motions = last_motion(program.joints, np.arange(len(program)) > 0)
    return motions[np.clip(np.searchsorted(program.end, path), 0, len(program) - 1)]


def _torque_constants(signal: JointSignals, place: str, count: int) -> Floats:
    """Return (L,) N·m per ampere."""
    if signal.torque_constant is None:
        raise InputError.at(
            FaultCode.KEY_MISSING,
            "campaign.toml", f"{place}.torque_constant", "a simulated motor current needs the motors' torque constant",
            "add torque_constant = 0.8, say (N*m per ampere, one number or one per joint)",
        )  # fmt: skip
    return np.broadcast_to(np.array(signal.torque_constant), (count,))


def as_columns(signal: Signal, reading: SignalSamples, metres_of_rods: Mapping[str, float]) -> dict[str, Floats]:
    """Return a signal's columns in the lab's units.

    Parameters
    ----------
    signal : from the manifest.
    reading : with its errors.
    metres_of_rods : metres of a unit of each rod's reading.
    """
    value = reading.value
    if isinstance(signal, Pose) and reading.rotation is not None and signal.orientation is not None:
        kind, _ = signal.orientation
        rotation = rotation_from_vector(value[:, 3:]) @ reading.rotation
        written = {
            "quaternion_wxyz": quaternion_from_rotation,
            "rotvec": vector_from_rotation,
            "rpy": rpy_from_rotation,
        }[kind](rotation)
        value = np.concatenate([value[:, :3], written], axis=1)
    units = signal.columns_with_units()
    result = {}
    for number, name in enumerate(signal.column_names()):
        unit = units.get(name)
        column = np.ascontiguousarray(value[:, number])
        if isinstance(signal, Lengths):
            result[name] = column / metres_of_rods[name]
        else:
            result[name] = column if unit is None else (column - unit.offset) / unit.factor
    return result


def decimals_of(signal: Signal) -> dict[str, int]:
    """Return with how many decimals each column of a signal is written to text logs."""
    units = signal.columns_with_units()
    result = {}
    for name in signal.column_names():
        unit = units.get(name)
        if unit is None:
            result[name] = _QUATERNION_DECIMALS
        else:
            step = _WRITTEN_STEP.get(unit.quantity, 1e-6) / unit.factor
            result[name] = max(0, int(np.ceil(-np.log10(step) - 1e-9)))
    return result
