"""Frames: every parent exists, none goes round in a circle, every rotation is one."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches

from stiffcal.campaign.found.experiment_kinds import any_measures
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.tracker_frames import two_frames_fault
from stiffcal.campaign.robot.sizes import FARTHEST_ON_A_ROBOT_M, implausible_length
from stiffcal.campaign.signals.signals import DeadWeight, Deflection, Displacement, Pose
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.state_measures import StateMeasure

_MANIFEST = "campaign.toml"
BUILT_IN = ("base", "flange")


def frame_fault(manifest: Manifest, links: tuple[str, ...] | None, frame: str, place: str) -> Fault | None:
    """Return a fault where `frame` is neither in the manifest nor built in nor a link.

    Parameters
    ----------
    links : the robot's link names; None where the robot could not be read: a name might then be a link.
    """
    frame_names = (*manifest.frames, *BUILT_IN, *(links or ()))
    if frame in frame_names or links is None:
        return None
    suggestions = get_close_matches(frame, frame_names, n=1)
    mend = (
        f'did you mean "{suggestions[0]}"?'
        if suggestions
        else f"add [frames.{frame}], or use one of " + ", ".join(frame_names)
    )
    return Fault(FaultCode.FRAME_UNKNOWN, _MANIFEST, place, f'there is no frame "{frame}"', mend, (frame,))


def frame_faults(manifest: Manifest, links: tuple[str, ...] | None) -> Iterator[Fault]:
    """Check all frames of a manifest."""
    for name, frame in manifest.frames.items():
        place = f"frames.{name}"
        if name in BUILT_IN:
            yield Fault(
                FaultCode.NAME_INVALID,
                _MANIFEST,
                place,
                f'the frame "{name}" is the robot\'s own',
                "give this frame another name",
                (name,),
            )
        mistake = frame.rotation_mistake()
        if mistake is not None:
            key, correction = mistake
            yield Fault(FaultCode.VALUE_INVALID, _MANIFEST, f"{place}.{key}", correction.reason, correction.mend)
        yield from _far_frame_faults(manifest, name)
        if frame.sigma_m is not None and not hangs_a_payload(manifest, name):
            reason = "sigma_m applies to the position of a known mass in absolute runs, and this frame has none"
            mend = "remove sigma_m, or use the frame as point of dead_weight"
            yield Fault(FaultCode.KEY_CONFLICT, _MANIFEST, f"{place}.sigma_m", reason, mend)
        if frame.level and not (frame.estimate and frame.parent == "base" and _measures(manifest, name)):
            reason = "level applies to the frame of an instrument that stands in base and is estimated"
            mend = 'remove level, or write parent = "base" and estimate = true'
            yield Fault(FaultCode.KEY_CONFLICT, _MANIFEST, f"{place}.level", reason, mend)
        fault = frame_fault(manifest, links, frame.parent, f"{place}.parent")
        if fault is not None:
            yield fault
    twice = two_frames_fault(manifest)
    if twice is not None:
        yield twice
    yield from _circles(manifest)
    yield from _moving_axes(manifest)


def _measures(manifest: Manifest, frame: str) -> bool:
    """Return whether poses are measured in a frame."""
    return any(pose.frame == frame for source in manifest.sources.values() for pose in source.body_poses().values())


def hangs_a_payload(manifest: Manifest, frame: str) -> bool:
    """Return whether a known mass hangs in a frame that is not itself estimated, in a campaign with absolute runs."""
    loads = [signal for _, _, signal in manifest.signals() if isinstance(signal, DeadWeight)]
    absolute = any_measures((run.experiment for run in manifest.runs), StateMeasure.PLACE)
    return absolute and not manifest.frames[frame].estimate and any(load.point == frame for load in loads)


def _far_frame_faults(manifest: Manifest, name: str) -> Iterator[Fault]:
    """Yield a fault where a frame on the flange or on a link has an implausibly large offset from it.

    Frames whose parent is the base or another frame of the manifest are skipped: a tracker may stand metres away.
    """
    frame = manifest.frames[name]
    for length in frame.xyz_m if frame.parent not in ("base", *manifest.frames) else ():
        mistake = implausible_length(length, FARTHEST_ON_A_ROBOT_M)
        if mistake is not None:
            yield Fault(FaultCode.VALUE_INVALID, _MANIFEST, f"frames.{name}.xyz_m", mistake.reason, mistake.mend)


def _circles(manifest: Manifest) -> Iterator[Fault]:
    done: set[str] = set()
    for name in manifest.frames:
        path: dict[str, None] = {}
        current = name
        while current in manifest.frames and current not in done and current not in path:
            path[current] = None
            current = manifest.frames[current].parent
        if current in path:
            names = list(path)
            circle = " → ".join([*names[names.index(current) :], current])
            yield Fault(
                FaultCode.FRAME_UNSUITABLE,
                _MANIFEST,
                f"frames.{current}.parent",
                f"the parents form a loop: {circle}",
                "break it",
            )
        done.update(path)


def rides_on(manifest: Manifest, frame: str) -> str:
    """Return the last parent of a frame: "base", "flange" or a link; the frame itself in a circle."""
    current, steps = frame, 0
    while current in manifest.frames and steps <= len(manifest.frames):
        current, steps = manifest.frames[current].parent, steps + 1
    return current


def _moving_axes(manifest: Manifest) -> Iterator[Fault]:
    """Yield a fault for every signal that is read in fixed axes and whose frame moves with the robot."""
    for source, name, signal in manifest.signals():
        key, frame = "", None
        if isinstance(signal, Pose):
            key, frame = "frame", signal.frame
        elif isinstance(signal, Deflection):
            key, frame = "axes", signal.axes
        elif isinstance(signal, Displacement):
            continue  # a gauge may ride on a link
        if frame is None:
            continue
        carrier = rides_on(manifest, frame)
        if carrier != "base" and carrier not in manifest.frames:
            reason = f'the frame "{frame}" moves with the robot (it is fixed to {carrier})'
            place = f"sources.{source}.{name}.{key}"
            mend = "measure in a frame whose parent is base"
            yield Fault(FaultCode.FRAME_UNSUITABLE, _MANIFEST, place, reason, mend, (frame,))
