"""Where the instruments sit: the manifest's frames on the robot's bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.checks.absolute_checks import absolute_sources
from stiffcal.campaign.found.experiment_kinds import any_measures
from stiffcal.campaign.frames.gauges import gauges_of, rods_of, sigma_of_gauges, sigma_of_rods
from stiffcal.campaign.frames.markers import markers_of
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.tracker_frames import tracker_frames
from stiffcal.campaign.robot.transforms import placement_matrix
from stiffcal.campaign.signals.displacement_signals import WITHOUT_UNIT
from stiffcal.campaign.signals.signals import DeadWeight, Deflection, JointSignals, Pose, Signal, Wrench
from stiffcal.campaign.toml.naming import body_number
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import HELD, Attachment, MeasurementSetup, Sigma, TrackerPlace
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.chain import Chain


def frames_to_estimate(manifest: Manifest) -> tuple[str, ...]:
    """Return the names of the frames that the manifest wants found by registration."""
    return tuple(name for name, frame in manifest.frames.items() if frame.estimate)


def resolve_frames(
    manifest: Manifest, chain: Chain, estimated: Mapping[str, Floats] | None = None
) -> dict[str, Attachment]:
    """Put every frame on the body that carries it.

    Parameters
    ----------
    manifest : checked: parents exist and do not go round.
    chain : the robot.
    estimated : (4, 4) parent_from_frame, m, of frames found by registration; frames that hang on them follow.

    Returns
    -------
    dict
        Frame name to its body and body_from_frame; ``base``, ``flange`` and the links' names stand there too. A frame
        to be estimated that is not in `estimated` is where the manifest starts it.

    Raises
    ------
    InputError
        A parent is unknown, or parents go round.
    """
    attachments: dict[str, Attachment] = {}
    for name in ("base", "flange", *chain.link_names, *chain.beams):
        body = body_number(name, chain.link_names)
        if body is not None:
            attachments[name] = Attachment(body, np.eye(4))
    for name in manifest.frames:
        attachments[name] = _attach(name, manifest, attachments, estimated or {})
    return attachments


def _attach(
    name: str, manifest: Manifest, attachments: Mapping[str, Attachment], estimated: Mapping[str, Floats]
) -> Attachment:
    transform = np.eye(4)
    current = name
    for _ in range(len(manifest.frames)):
        frame = manifest.frames[current]
        transform = estimated.get(current, placement_matrix(frame)) @ transform
        current = frame.parent
        if current not in manifest.frames:
            break
    if current not in attachments:
        raise InputError.at(
            FaultCode.FRAME_UNKNOWN,
            "campaign.toml",
            f"frames.{name}",
            f'no body "{current}"',
            "correct the frame's parent",
        )
    return Attachment(attachments[current].body, attachments[current].transform @ transform)


@dataclass(frozen=True)
class _Load:
    """The manifest's description of the load: sigma in N and N·m; `is_weight` of a known mass."""

    axes: str
    point: str
    moments: bool
    force_sigma: float | None
    moment_sigma: float | None
    tared: str
    is_weight: bool = False


def measurement_setup(manifest: Manifest, chain: Chain, frames: Mapping[str, Attachment]) -> MeasurementSetup:
    """Gather where load and displacement are measured.

    Parameters
    ----------
    manifest, chain : checked by `load_campaign`.
    frames : of `resolve_frames`, estimated frames put in.

    Returns
    -------
    MeasurementSetup
        Targets from the outermost body inwards, on one body in the order of the manifest: the first is what moves most,
        the tool. Without any wrench the load is none: axes and point are the flange's.

    Raises
    ------
    InputError
        Two wrenches, which load states cannot hold. Devices that press along one line each may be several, one per run.
    """
    load = _load(manifest, float(np.linalg.norm(chain.gravity)))
    targets = _targets(manifest)
    targets = tuple(sorted(targets, key=lambda name: -frames[name].body))
    tool, links = manifest.tool, rods_of(manifest, chain)
    return MeasurementSetup(
        wrench_axes=frames[load.axes],
        wrench_point=frames[load.point],
        targets=tuple(frames[name] for name in targets),
        target_names=targets,
        moments_measured=load.moments,
        trackers=tuple(
            TrackerPlace(name if name in manifest.frames else "", frames[name].transform)
            for name in tracker_frames(manifest)
        ),
        estimated=frames_to_estimate(manifest),
        load_is_weight=load.is_weight,
        load_point_sigma=load_point_sigma(manifest, load.point),
        torque_gain_sigma=torque_gain_sigma(manifest),
        tool_mass=0.0 if tool is None else tool.mass_kg,
        tool_com=np.zeros(3) if tool is None else np.array(tool.com_m),
        sigma=_sigma(manifest, load),
        tared=load.tared,
        rods=tuple(rods for rods, _ in links),
        beams=tuple(beam for _, beam in links),
        gauges=gauges_of(manifest, frames, targets),
        markers=markers_of(manifest, targets),
    )


def load_point_sigma(manifest: Manifest, point: str) -> float:
    """Return how well the place where the load acts is known, m per axis; 0 where nothing is stated."""
    frame = manifest.frames.get(point)
    return 0.0 if frame is None or frame.sigma_m is None else frame.sigma_m


def torque_gain_sigma(manifest: Manifest) -> float:
    """Return the relative uncertainty of each motor's torque that holds the robot; 0 where none is stated."""
    stated = [signal.torque_gain_sigma for _, _, signal in manifest.signals() if isinstance(signal, JointSignals)]
    return next((sigma for sigma in stated if sigma is not None), 0.0)


def _load(manifest: Manifest, gravity: float) -> _Load:
    loads: list[tuple[str, _Load]] = []
    for source, name, signal in manifest.signals():
        place = f"sources.{source}.{name}"
        if isinstance(signal, Wrench):
            sigma = signal.sigma
            gauge = manifest.sources[source].displacement
            axes = signal.axes_frame or (gauge.axes if gauge is not None else "base")
            force = None if sigma is None or sigma.force is None else sigma.force * signal.unit_of("force").factor
            moment = None if sigma is None or sigma.moment is None else sigma.moment * signal.unit_of("moment").factor
            point = signal.point_frame or axes
            loads.append((place, _Load(axes, point, signal.moments_measured, force, moment, signal.tared)))
        elif isinstance(signal, DeadWeight) and manifest.sources[source].wrench is None:
            # Next to a measured force it is what that force is compared with (stiffcal.mistakes.known_weights).
            mass = None if signal.sigma is None else signal.sigma.mass
            force = None if mass is None else mass * signal.unit_of("mass").factor * gravity
            loads.append((place, _Load("base", signal.point, False, force, None, "no", is_weight=True)))
    one_line = all(isinstance(s, Wrench) and len(s.columns) == 1 for _, _, s in manifest.signals() if _is_load(s))
    if len(loads) > 1 and not (
        one_line and len({load for _, load in loads}) == 1 and _each_run_reads_one_load(manifest)
    ):
        reason = f"the load is measured twice, here and in {loads[0][0]}"
        raise InputError.at(FaultCode.KEY_CONFLICT, "campaign.toml", loads[1][0], reason, "keep one of them")
    if loads:
        return loads[0][1]
    # Clamped runs without a force sensor: what holds the flange follows from the motor's torque, moments included.
    from_motors = any_measures((run.experiment for run in manifest.runs), StateMeasure.MOTOR_ANGLE)
    return _Load("flange", "flange", from_motors, None, None, "run")


def _is_load(signal: Signal) -> bool:
    return isinstance(signal, Wrench | DeadWeight)


def _each_run_reads_one_load(manifest: Manifest) -> bool:
    """Return whether no run reads two loads: each names the file of one of the sources that hold a load."""
    holders = {source for source, _, signal in manifest.signals() if _is_load(signal)}
    return not any(manifest.files_of(source) for source in holders) and all(
        len(holders & set(run.files)) <= 1 for run in manifest.runs
    )


def _targets(manifest: Manifest) -> tuple[str, ...]:
    """Return the measured frames in order."""
    names: list[str] = []
    for settings in manifest.sources.values():
        names += settings.body_poses()
        if settings.deflection is not None:
            names.append(settings.deflection.body)
        if settings.displacement is not None:
            names.append(settings.displacement.body)
    return tuple(dict.fromkeys(names))


def _sigma(manifest: Manifest, load: _Load) -> Sigma:
    """Return the stated uncertainties in SI; of several displacement signals the first that states one.

    Sources that absolute runs read come last: theirs is that of places, and of displacements where no other states one.
    """
    translation: float | None = None
    rotation: float | None = None
    of_absolute = absolute_sources(manifest)
    place: float | None = None
    place_turn: float | None = None
    for source, _, signal in sorted(manifest.signals(), key=lambda entry: entry[0] in of_absolute):
        if isinstance(signal, Pose):
            stated, stated_turn = _sigma_of_pose(manifest, signal, source in of_absolute)
            translation, rotation = translation or stated, rotation or stated_turn
            if source in of_absolute:
                place, place_turn = place or stated, place_turn or stated_turn
        elif isinstance(signal, Deflection) and signal.sigma is not None:
            translation = translation or _scaled(signal.sigma.translation, signal.unit_of("translation").factor)
            rotation = rotation or _scaled(signal.sigma.rotation, signal.unit_of("rotation").factor)
    rods, gauges = sigma_of_rods(manifest), sigma_of_gauges(manifest)
    motors = _motor_sigma(manifest)
    return Sigma(translation, rotation, load.force_sigma, load.moment_sigma, rods, gauges, motors, place, place_turn)


def _sigma_of_pose(manifest: Manifest, pose: Pose, absolute: bool) -> tuple[float | None, float | None]:
    """Return the stated uncertainty of a pose, m, rad; of absolute places by points it follows from that of a point."""
    if pose.sigma is None:
        return None, None
    quaternion = pose.orientation is None or pose.orientation[0] in WITHOUT_UNIT
    position = _scaled(pose.sigma.position, pose.unit_of("position").factor)
    rotation = _scaled(pose.sigma.rotation, 1.0 if quaternion else pose.unit_of("rotation").factor)
    if pose.markers and absolute and position is not None and rotation is None:
        (points,) = markers_of(manifest, (pose.body or "target",))
        return (None, None) if points is None else points.pose_sigma(position)
    return position, rotation


def sigma_of_places(manifest: Manifest) -> dict[str, tuple[float | None, float | None]]:
    """Return what each target of absolute runs states as its uncertainty, m and rad, by its name.

    None where it states none, or states it row by row.

    Raises
    ------
    InputError : points of a body that are not in the manifest.
    """
    of_absolute = absolute_sources(manifest)
    return {
        signal.body or "target": _sigma_of_pose(manifest, signal, absolute=True)
        for source, _, signal in manifest.signals()
        if isinstance(signal, Pose) and source in of_absolute
    }


def holding(setup: MeasurementSetup) -> MeasurementSetup:
    """Return the set-up with the frame by which a clamped robot is held among its targets: the force sensor's."""
    if HELD in setup.target_names:
        return setup
    return replace(setup, targets=(*setup.targets, setup.wrench_point), target_names=(*setup.target_names, HELD))


def _motor_sigma(manifest: Manifest) -> float | None:
    """Return the stated uncertainty of a joint's angle, rad; motor-side logs state it of the motor: not returned."""
    for _, _, signal in manifest.signals():
        if isinstance(signal, JointSignals) and not signal.motor and signal.sigma is not None:
            return _scaled(signal.sigma.position, signal.unit_of("position").factor)
    return None


def _scaled(value: float | tuple[str, ...] | None, factor: float) -> float | None:
    """Return a stated number in SI; what columns hold is known with the readings only."""
    return value * factor if isinstance(value, float) else None
