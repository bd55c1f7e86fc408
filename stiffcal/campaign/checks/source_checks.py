"""Sources of campaign.toml: their files, runs, formats and signals hold together."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.campaign.checks.frame_checks import frame_fault
from stiffcal.campaign.checks.run_checks import choices
from stiffcal.campaign.manifest.file_patterns import ANY, RUN
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.signals.signals import (
    DeadWeight,
    Deflection,
    Displacement,
    Lengths,
    Pose,
    Signal,
    Wrench,
)
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode


def _fault(code: FaultCode, place: str, reason: str, mend: str, *names: str) -> Fault:
    return Fault(code, MANIFEST_FILE, place, reason, mend, names)


def source_faults(manifest: Manifest) -> Iterator[Fault]:
    """Check files, runs and formats of every source."""
    for name, source in manifest.sources.items():
        place = f"sources.{name}"
        signals = source.signals()
        if not signals:
            yield _fault(
                FaultCode.SIGNAL_MISSING,
                place,
                "the source contains no signal",
                "add joints, wrench, pose, deflection, …",
            )
        if source.file is not None and source.files:
            yield _fault(FaultCode.KEY_CONFLICT, f"{place}.files", "both file and files are given", "keep one of them")
        for signal, file in source.files.items():
            if source.in_files and RUN in file:
                yield _fault(
                    FaultCode.VALUE_INVALID,
                    f"{place}.files.{signal}",
                    f"{RUN} stands for the run's name in file alone",
                    "name one file for all runs, or write the pattern under file",
                )
            if signal not in (*signals, "time", "run"):
                yield _fault(
                    FaultCode.SOURCE_UNKNOWN,
                    f"{place}.files.{signal}",
                    f'the source has no signal "{signal}"',
                    choices(signal, signals),
                    signal,
                )
        if not source.is_states and source.time is None:
            mend = (
                'add time = { column = "t", unit = "s" } or { rate_hz = 5000 }; for averaged states sampling = "states"'
            )
            yield _fault(FaultCode.KEY_MISSING, place, "the source is logged over time, but has no time", mend)
        yield from _source_run_faults(manifest, name, source)
        yield from _format_faults(manifest, name, source)


def _has_own_file(source: Source) -> bool:
    return source.own_file is not None or bool(source.files)


def _source_run_faults(manifest: Manifest, name: str, source: Source) -> Iterator[Fault]:
    """See that every source's files can be put to runs."""
    place = f"sources.{name}"
    in_runs = [run.id for run in manifest.runs if name in run.files]
    own = _has_own_file(source)
    if not own and not in_runs and source.pattern is None:
        yield _fault(
            FaultCode.KEY_MISSING,
            place,
            "no file is named",
            f'add file = "raw/table.csv", or {toml_text.pair("files", {name: "raw/run1.csv"})} to each run',
        )
    if own and in_runs:
        yield _fault(
            FaultCode.KEY_CONFLICT, place, 'a file is given here and in run '
        f'"{in_runs[0]}"', "give it in one place only",
            in_runs[0],
        )  # fmt: skip
    if own and source.run is None and len(manifest.runs) != 1:
        mend = 'add run = { column = "run" } or run = { each = "row" }'
        if not source.is_states:
            mend += f", or [[runs]] with {toml_text.pair('files', {name: 'raw/run1.csv'})} for each"
        yield _fault(FaultCode.KEY_MISSING, place, "it is not stated to which run a row belongs", mend)
    if source.run is not None and source.run.each == "row" and not source.is_states:
        yield _fault(
            FaultCode.KEY_CONFLICT,
            f"{place}.run",
            "a row logged over time cannot be a separate run",
            'use { column = "run" }',
        )


def _format_faults(manifest: Manifest, name: str, source: Source) -> Iterator[Fault]:
    if source.format is not None:
        return
    own = list(source.files.values()) or ([source.file] if source.file is not None else [])
    files = own + [run.files[name] for run in manifest.runs if name in run.files]
    for file in files:
        if ANY in file.rpartition(".")[2]:  # a pattern of files in several formats, which each show their own
            continue
        if source.format_for(file) is None:
            yield _fault(
                FaultCode.FORMAT_UNKNOWN,
                f"sources.{name}",
                f'the ending of "{file}" does not determine the format',
                'add format = "csv", say',
            )
            return


def signal_faults(manifest: Manifest, links: tuple[str, ...] | None) -> Iterator[Fault]:
    """Check every signal: its frames, links and wrench. ``links``: names of the robot's; None where it is not read."""
    for source, name, signal in manifest.signals():
        place = f"sources.{source}.{name}"
        for key, frame in frames_of_signal(signal, name):
            fault = frame_fault(manifest, links, frame, f"{place}.{key}")
            if fault is not None:
                yield fault
        if isinstance(signal, Wrench):
            yield from _wrench_faults(signal, manifest.sources[source], place)
        if isinstance(signal, Displacement | Wrench) and signal.direction is not None and not any(signal.direction):
            yield _fault(
                FaultCode.VALUE_INVALID,
                f"{place}.direction",
                "the direction is zero",
                "write a vector such as [0, 0, 1]",
            )
        if isinstance(signal, Lengths):
            for column in signal.columns:
                if column not in manifest.ids:
                    reason = f'the fixing points of rod "{column}" are not given'
                    yield _fault(
                        FaultCode.KEY_MISSING,
                        f"{place}.columns",
                        reason,
                        f"add [ids.{column}] with link, start_m, end_m",
                        column,
                    )
        if isinstance(signal, Pose):
            for marker, point in signal.markers.items():
                if point.at_m is None and marker not in manifest.frames:
                    yield _fault(
                        FaultCode.KEY_MISSING,
                        f"{place}.markers.{marker}",
                        "its position on the body is not stated",
                        "write it as a table of columns and at_m = [0.0, 0.05, 0.1], say, in metres",
                    )
    for name, rod in manifest.ids.items():
        if links is not None and rod.link not in links:
            yield _fault(
                FaultCode.LINK_UNKNOWN,
                f"ids.{name}.link",
                f'the robot has no link "{rod.link}"',
                choices(rod.link, links),
                rod.link,
            )


def frames_of_signal(signal: Signal, name: str) -> list[tuple[str, str]]:
    """Return (key, frame) of every frame a signal names."""
    named_frames: list[tuple[str, str | None]] = []
    if isinstance(signal, Wrench):
        named_frames = [("frame", signal.frame), ("axes", signal.axes), ("point", signal.point)]
    elif isinstance(signal, Pose):
        body = signal.body or (name.removeprefix("poses.") if name != "pose" else "target")
        named_frames = [("frame", signal.frame), ("body", body)]
    elif isinstance(signal, Deflection | Displacement):
        named_frames = [("body", signal.body), ("axes", signal.axes)]
    elif isinstance(signal, DeadWeight):
        named_frames = [("point", signal.point)]
    return [(key, frame) for key, frame in named_frames if frame is not None]


def _wrench_faults(wrench: Wrench, source: Source, place: str) -> Iterator[Fault]:
    gauge = source.displacement
    if wrench.axes_frame is None and not (len(wrench.columns) == 1 and gauge is not None):
        yield _fault(
            FaultCode.KEY_MISSING,
            place,
            "the axes of the wrench are not stated",
            'add frame = "ft_sensor", or axes and point',
        )
    if wrench.point_frame is None:
        if len(wrench.columns) == 6:
            yield _fault(
                FaultCode.KEY_MISSING,
                place,
                "the point that the moments refer to is missing",
                'add point = "ft_sensor", say',
            )
        else:
            reason = "a force without moments needs its point of application"
            yield _fault(FaultCode.KEY_MISSING, place, reason, 'add point = "load_point", a frame under [frames]')
    if len(wrench.columns) == 1 and wrench.direction is None and gauge is None:
        yield _fault(
            FaultCode.KEY_MISSING, place, "a force of one column needs a direction", "add direction = [0, 0, 1], say"
        )
    if len(wrench.columns) != 1 and wrench.direction is not None:
        yield _fault(
            FaultCode.KEY_CONFLICT,
            f"{place}.direction",
            "a direction applies to a force of one column only",
            "remove it",
        )
