"""Frames in which places are read: one for each place where the tracker stood, with sources of its own."""

from __future__ import annotations

from stiffcal.campaign.manifest.manifest import Manifest, Run
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode


def tracker_frames(manifest: Manifest) -> tuple[str, ...]:
    """Return the frames in which places or displacements are read, in the order of the sources; the base of none."""
    frames = dict.fromkeys(frame for source in manifest.sources.values() for frame in _frames_read(source))
    return tuple(frames) or ("base",)


def _frames_read(source: Source) -> tuple[str, ...]:
    poses = tuple(pose.frame for pose in source.body_poses().values())
    return poses if source.deflection is None else (*poses, source.deflection.axes)


def trackers_of_runs(manifest: Manifest) -> dict[str, int]:
    """Return which of the `tracker_frames` each run of the manifest reads, the first where it reads none.

    A tracker that was moved has a frame for each place, and sources of its own there, which runs name among their
    files.
    """
    frames = tracker_frames(manifest)
    if len(frames) == 1:
        return {run.id: 0 for run in manifest.runs}
    return {run.id: frames.index(next(iter(_read_by(manifest, run)), frames[0])) for run in manifest.runs}


def _read_by(manifest: Manifest, run: Run | None) -> dict[str, str]:
    """Return the frames that a run reads, with the first source of each; None: what is read whatever the run."""
    read: dict[str, str] = {}
    for name, source in manifest.sources.items():
        if manifest.files_of(name, run):
            for frame in _frames_read(source):
                read.setdefault(frame, name)
    return read


def two_frames_fault(manifest: Manifest) -> Fault | None:
    """Return the fault of a run that reads places in two frames, which its load states cannot hold."""
    runs = (None, *manifest.runs) if len(tracker_frames(manifest)) > 1 else ()
    for run in runs:
        read = list(_read_by(manifest, run).items())
        if len(read) > 1:
            (first, source), (second, place) = read[:2]
            reason = f'places are read in "{second}" here and in "{first}" in sources.{source}'
            reason += "" if run is None else f', both of run "{run.id}"'
            mend = "let each run name the logs of one of them (files in [[runs]]), or express all in one frame"
            return Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"sources.{place}", reason, mend)
    return None


def instead_of(manifest: Manifest) -> dict[str, str]:
    """Return source to the first one that measures the same bodies, for those that do so in several frames.

    A run has the logs of one of them.
    """
    groups: dict[tuple[str, ...], list[str]] = {}
    for name, source in manifest.sources.items():
        bodies = (*source.body_poses(), *(() if source.deflection is None else (source.deflection.body,)))
        if bodies:
            groups.setdefault(tuple(sorted(bodies)), []).append(name)
    return {
        name: names[0]
        for names in groups.values()
        if len({_frames_read(manifest.sources[name]) for name in names}) == len(names) > 1
        for name in names
    }
