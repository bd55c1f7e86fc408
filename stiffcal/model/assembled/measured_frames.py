"""The frames that a fit of absolute places finds together with the robot: where the tracker and the targets are.

They are set-up parameters of the same fit, ``frame.tracker.x`` to ``frame.target1.rz``: small motions from where
registration has put the frame with the robot file's geometry, in the axes of the body that carries it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.rotations import inverse_transform, rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import (
    Inputs,
    Instrument,
    ParameterRole,
    ParameterSpec,
    Place,
    Values,
)

FRAME = "frame"
"""What parameter names of frames begin with."""
AXES = ("x", "y", "z", "rx", "ry", "rz")
_SOURCE = "registration with the geometry of the robot file: some tenths of a millimetre and of a milliradian"


def _spec(symbol: str) -> ParameterSpec:
    turn = symbol.startswith("r")
    return ParameterSpec(
        symbol,
        "rad" if turn else "m",
        f"{'turn about' if turn else 'shift along'} {symbol[-1]} relative to the registered frame",
        -0.5,
        0.5,
        1e-3,
        _SOURCE,
        ParameterRole.SETUP,
    )


def _load_point_spec(symbol: str) -> ParameterSpec:
    meaning = f"displacement of the payload position along {symbol} from the manifest"
    source = "centre of mass of a payload from a drawing or a ruler: a few millimetres"
    return ParameterSpec(symbol, "m", meaning, -1.0, 1.0, 5e-3, source, ParameterRole.SETUP)


class FramePosition(Instrument):
    """A frame of which only the place is found: a target whose orientation is not measured.

    Law: its origin is where registration puts it plus (x, y, z), in the axes of the body that carries it.
    """

    name = FRAME
    place_kind = "frames"
    summary = "position of a frame that the manifest leaves to be estimated"
    parameters = tuple(_spec(symbol) for symbol in AXES[:3])

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Move the target, or the tracker, of that name."""
        small = np.array([values.get(symbol, 0.0) for symbol in AXES])
        if not small.any():
            return inputs
        setup = inputs.setup
        if place.frame in setup.target_names:
            targets = tuple(
                Attachment(target.body, _moved(target.transform, small)) if name == place.frame else target
                for name, target in zip(setup.target_names, setup.targets, strict=True)
            )
            return replace(inputs, setup=replace(setup, targets=targets))
        frames = [tracker.frame for tracker in setup.trackers]
        if place.frame not in frames:
            return inputs  # points of the robot itself are asked for, none that were measured
        error = np.tile(np.eye(4), (len(frames), 1, 1)) if inputs.tracker_error is None else inputs.tracker_error.copy()
        number = frames.index(place.frame)
        registered = setup.trackers[number].base_from_frame
        present = inverse_transform(error[number]) @ registered
        error[number] = registered @ inverse_transform(_moved(present, small))
        return replace(inputs, tracker_error=error)


class LoadPoint(Instrument):
    """The position of a payload, known within a standard uncertainty that the manifest states.

    Law: the load acts at the manifest's place plus (x, y, z), in the axes of the body that carries it; each of these is
    normally distributed about 0 with that uncertainty (`MeasurementSetup.load_point_sigma`).
    """

    name = FRAME
    place_kind = "frames"
    summary = "position of the payload, within the uncertainty that the manifest states"
    parameters = tuple(_load_point_spec(symbol) for symbol in AXES[:3])

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Move the point where the load acts."""
        shift = np.array([values.get(symbol, 0.0) for symbol in AXES[:3]])
        if not shift.any():
            return inputs
        point = inputs.setup.wrench_point
        transform = point.transform.copy()
        transform[:3, 3] += shift
        return replace(inputs, setup=replace(inputs.setup, wrench_point=replace(point, transform=transform)))


class FramePose(FramePosition):
    """A frame whose place and orientation are found: the tracker's, or a target's whose orientation is measured.

    Law: its origin moves by (x, y, z) and its axes turn by the rotation vector (rx, ry, rz), in the axes of the body
    that carries it.
    """

    parameters = tuple(_spec(symbol) for symbol in AXES)


class LevelFrame(FramePosition):
    """The frame of a levelled instrument: its place, and its turn about the vertical.

    Law: its origin moves by (x, y, z) and its axes turn by rz, in the axes of the base, whose z axis is vertical.
    """

    parameters = tuple(_spec(symbol) for symbol in (*AXES[:3], AXES[5]))


def placed_frame(name: str, with_orientation: bool, level: bool = False) -> PlacedEffect:
    """Return the frame of that name as part of a model; `level` where its z axis is known to point up."""
    effect = LevelFrame() if level else FramePose() if with_orientation else FramePosition()
    return PlacedEffect(effect, Place("frames", frame=name))


def placed_load_point(name: str) -> PlacedEffect:
    """Return the frame in which a payload is attached as part of a model."""
    return PlacedEffect(LoadPoint(), Place("frames", frame=name))


def with_found_frames(robot: CompliantRobot, setup: MeasurementSetup) -> MeasurementSetup:
    """Return the set-up with trackers and targets where a fit has found them, in the axes of the fitted robot's base.

    Parameters
    ----------
    robot : with the fitted values, frames among them. setup : with the frames where registration put them.
    """
    inputs = Inputs(np.zeros((robot.chain.n_joints, 1)), np.zeros((6, 1)), setup)
    for placed in robot.placed:
        if isinstance(placed.effect, FramePosition):
            inputs = placed.adjusted(inputs)
    if inputs.tracker_error is None:
        return inputs.setup
    trackers = tuple(
        replace(tracker, base_from_frame=inverse_transform(error) @ tracker.base_from_frame)
        for tracker, error in zip(setup.trackers, inputs.tracker_error, strict=True)
    )
    return replace(inputs.setup, trackers=trackers)


def _moved(body_from_frame: Floats, small: Floats) -> Floats:
    """Return the frame, shifted and turned about its origin in the body's axes."""
    result = np.eye(4)
    result[:3, :3] = rotation_from_vector(small[3:]) @ body_from_frame[:3, :3]
    result[:3, 3] = body_from_frame[:3, 3] + small[:3]
    return result
