"""The files of a folder, put to the devices that wrote them: what they hold, and which runs they make."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath

from stiffcal.campaign.found.file_formats import format_of
from stiffcal.campaign.manifest.file_patterns import FilePattern, FoundFiles, files_of_runs
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.natural_order import natural_key
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.lines import FrameNames
from stiffcal.propose.log_kind import LogKind, log_kind, source_name
from stiffcal.propose.run_names import patterns_of_devices, shape_of
from stiffcal.propose.signal_lines import signal_lines
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.propose.unnamed_columns import are_numbered

OF_A_CAMPAIGN = frozenset({MANIFEST_FILE, "robot.toml", "model.toml", "simulate.toml", "plan.toml", "truth.json"})
MOST_NAMED = 5
BAG = "metadata.yaml"
"""Makes a folder one log: a ROS 2 bag."""

JointsOf = Callable[[Sequence[SniffedColumn]], Sequence[SniffedColumn]]
"""Returns those of a log's columns that hold the joints, base to tip, by the names of a robot's joints."""


@dataclass
class LoggingDevice:
    """Files of the same columns."""

    kind: LogKind
    files: list[str] = field(default_factory=list)
    also: list[LogKind] = field(default_factory=list)
    """What the files are that hold the same columns in another format."""
    name: str = ""
    pattern: str = ""


@dataclass(frozen=True)
class SortedFiles:
    """The files of a folder, by what they are."""

    devices: list[LoggingDevice]
    unused: list[str]
    """Why a file is not used: a sentence each."""


def files_in(logs: Path) -> list[str]:
    """Return every log of a folder, relative to it, in natural order: nothing hidden, no store, no file of a campaign.

    A folder that is a bag is one log.
    """
    found = []
    for here, folders, files in os.walk(logs):
        place, top = Path(here).relative_to(logs), Path(here) == logs
        if BAG in files and not top:
            folders.clear()
            found.append(place.as_posix())
            continue
        folders[:] = [name for name in folders if not name.startswith(".") and not (top and name == "store")]
        names = [name for name in files if not name.startswith(".") and not (top and name in OF_A_CAMPAIGN)]
        found += [(place / name).as_posix() for name in names]
    return sorted(found, key=lambda file: (natural_key(file), file))


def sorted_files(
    files: Mapping[str, Path], joints_of: JointsOf, names: FrameNames, chain: Chain | None = None
) -> SortedFiles:
    """Put files to the devices that wrote them.

    Of files whose names differ in numbers alone the first, the middle and the last are opened; where these differ in
    their columns, all are.

    Parameters
    ----------
    files : name in the campaign folder to the file, in natural order.
    joints_of : finds the columns of joints. names : the frames that the lines of signals name.
    chain : of the robot, by which columns without names are judged; None: it is not known.
    """
    found = SortedFiles([], [])
    by_shape: dict[tuple[str, ...], list[str]] = {}
    for file in files:
        by_shape.setdefault(shape_of(file), []).append(file)

    def kind_of(file: str) -> LogKind:
        return log_kind(files[file], file, names, joints_of, chain)

    devices: dict[tuple[object, ...], LoggingDevice] = {}
    not_read: dict[str, list[str]] = {}
    for alike in by_shape.values():
        opened = {file: kind_of(file) for file in dict.fromkeys((alike[0], alike[len(alike) // 2], alike[-1]))}
        if len({tuple(map(_layout, _parts(kind))) for kind in opened.values()}) > 1:
            opened = {file: opened.get(file) or kind_of(file) for file in alike}
        usual = next((kind for kind in opened.values() if not kind.why_not), next(iter(opened.values())))
        for file in alike:
            kind = opened.get(file, usual)
            if kind.why_not and are_numbered(kind.headers) and kind.headers == usual.headers:
                kind = usual  # this one's values leave open what those of another run decide
            if kind.why_not:
                not_read.setdefault(kind.why_not, []).append(file)
                continue
            if kind.not_understood:
                unclear = f"no signal recognised in {', '.join(kind.not_understood)}: not used"
                not_read.setdefault(unclear, []).append(file)
            for part in _parts(kind):
                device = devices.setdefault(_layout(part), LoggingDevice(part))
                device.files.append(file)
                if part.rows and not device.kind.rows:  # a target that is hidden at times
                    device.kind = part
    found.devices.extend(_of_any_format(list(devices.values())))
    found.unused.extend(f"{_named(alike)}: {why_not}" for why_not, alike in not_read.items())
    return found


def _of_any_format(devices: list[LoggingDevice]) -> list[LoggingDevice]:
    """Put devices together whose files differ in format alone: a log that was opened in a spreadsheet and saved."""
    kept: list[LoggingDevice] = []
    for device in sorted(devices, key=lambda device: -len(device.files)):
        same = next((other for other in kept if _in_place_of(device, other)), None)
        if same is None:
            kept.append(device)
        else:
            same.also.append(device.kind)
            same.files = sorted((*same.files, *device.files), key=lambda file: (natural_key(file), file))
    return [device for device in devices if device in kept]


def _in_place_of(device: LoggingDevice, other: LoggingDevice) -> bool:
    """Return whether the files of a device are read as those of another one, and stand in place of some of them."""
    columns, of_other = (
        (one.kind.headers, [line.toml for line in one.kind.signals], one.kind.time) for one in (device, other)
    )
    by_ending = all(format_of(file) == one.kind.format for one in (device, other) for file in one.files)
    stems = [{PurePosixPath(file).with_suffix("") for file in one.files} for one in (device, other)]
    return columns == of_other and device.kind.format != other.kind.format and by_ending and not stems[0] & stems[1]


def _parts(kind: LogKind) -> tuple[LogKind, ...]:
    """Return the sources in a log, one or several."""
    return (kind, *kind.further)


def _layout(kind: LogKind) -> tuple[object, ...]:
    """Return what the files of one device have in common."""
    signals = (
        tuple(line.toml for line in kind.signals) if are_numbered(kind.headers) else tuple(_signals(kind.roles))
    )  # columns without names hold what their values show
    return (kind.why_not, kind.format, kind.headers, signals, *sorted(kind.options.items()))


def of_use(found: SortedFiles, names: FrameNames) -> tuple[list[LoggingDevice], list[str]]:
    """Return the devices, each with what no other one with more files gives, and what is not used.

    Where an instrument reads a place, one that is logged with joint angles is the controller's, computed of them.
    """
    devices: list[LoggingDevice] = []
    unused, given = list(found.unused), dict[str, str]()

    def last(device: LoggingDevice) -> tuple[bool, int]:
        roles = device.kind.roles
        return roles.joints is not None and roles.position is not None, -len(device.files)

    for device in sorted(found.devices, key=last):
        roles = device.kind.roles
        again = [signal for signal in _signals(roles) if signal in given]
        if len(again) == len(_signals(roles)):
            others = " and ".join(dict.fromkeys(given[signal] for signal in again))
            text = f"{_named(device.files)}: {' and '.join(again)}, which {others} holds too, in other columns"
            unused.append(text)
            continue
        if again:
            if roles.joints is not None and "position" in again:
                unused.append(
                    f"{_named(device.files)}: position, taken from {given['position']}: joints are logged with it"
                )
            roles = _without(roles, again)
            name = device.kind.name if device.kind.device else source_name(roles)
            signals = tuple(signal_lines(roles, names))
            device.kind = replace(device.kind, name=name, roles=roles, signals=signals)
        given |= dict.fromkeys(_signals(roles), device.files[0])
        devices.append(device)
    order = {id(device): k for k, device in enumerate(found.devices)}
    return sorted(devices, key=lambda device: order[id(device)]), unused


def _signals(roles: Roles) -> list[str]:
    """Return the signals that a device gives, by the fields of `Roles`."""
    fields = {
        "joints": roles.joints, "force": roles.force, "mass": roles.mass, "deflection": roles.deflection,
        "position": roles.position,
    }  # fmt: skip
    return [name for name, role in fields.items() if role is not None]


def _without(roles: Roles, signals: Collection[str]) -> Roles:
    """Return what a device gives without some signals."""
    force, position = "force" in signals, "position" in signals
    return replace(
        roles,
        joints=None if "joints" in signals else roles.joints,
        mass=None if "mass" in signals else roles.mass,
        deflection=None if "deflection" in signals else roles.deflection,
        rotation=None if "deflection" in signals else roles.rotation,
        force=None if force else roles.force,
        moment=None if force else roles.moment,
        position=None if position else roles.position,
        quaternion=None if position else roles.quaternion,
    )


def together(devices: Sequence[LoggingDevice]) -> Roles:
    """Return what all devices measure together."""

    def first(signal: Callable[[Roles], Role | None]) -> Role | None:
        return next((role for device in devices if (role := signal(device.kind.roles)) is not None), None)

    return Roles(
        joints=first(lambda roles: roles.joints),
        force=first(lambda roles: roles.force),
        moment=first(lambda roles: roles.moment),
        deflection=first(lambda roles: roles.deflection),
        position=first(lambda roles: roles.position),
        mass=first(lambda roles: roles.mass),
    )


def with_patterns(devices: list[LoggingDevice], unused: list[str], place: str) -> tuple[list[LoggingDevice], list[str]]:
    """Return the devices with the patterns of their files and names for their sources.

    A device that logged less than half of the runs, and nothing that the others lack, is left out: with it, those runs
    alone would be left.

    Raises
    ------
    InputError : the names of the files hold no run.
    """
    patterns = patterns_of_devices({str(k): device.files for k, device in enumerate(devices)}, place)
    most = max((len(_names(device.files, patterns.get(str(k)))) for k, device in enumerate(devices)), default=0)
    kept = []
    for k, device in enumerate(devices):
        device.pattern = patterns.get(str(k), "")
        others = together([other for other in devices if other is not device])
        needed = {"joints", "force", "deflection", "position"}.intersection(_signals(device.kind.roles))
        if needed <= set(_signals(others)) and 2 * len(_names(device.files, device.pattern)) < most:
            unused.append(f"{_named(device.files)}: logs of fewer than half of the runs; {_HOW_TO_ADD}")
            continue
        kept.append(device)
    alone = all(len(device.files) == 1 for device in kept) and not any(device.pattern for device in kept)
    lost = [device for device in kept if not device.pattern]
    if lost and not alone:
        reason = "nothing in the names of the files tells the runs apart and is the same in all devices"
        mend = "name the logs RUN_DEVICE, pose01_force.csv and pose01_tracker.csv, or give each run a folder of its own"
        raise InputError.at(FaultCode.NAME_INVALID, _named(lost[0].files), "", reason, mend)
    names: set[str] = set()
    for device in kept:
        base = device.kind.name
        device.name = next(f"{base}{n or ''}" for n in (0, *range(2, 100)) if f"{base}{n or ''}" not in names)
        names.add(device.name)
    return kept, unused


_HOW_TO_ADD = "name them in [[runs]], under files, where they are to be used"


def _names(files: Collection[str], pattern: str | None) -> set[str]:
    if not pattern:
        return set()
    own = FilePattern(pattern)
    return {name for file in files if (name := own.run_of(file)) is not None}


def _named(files: Sequence[str]) -> str:
    more = len(files) - MOST_NAMED
    return ", ".join([*files[:MOST_NAMED], *([f"{more} more"] if more > 0 else [])])


def runs_of(devices: Sequence[LoggingDevice]) -> tuple[list[str], list[str]]:
    """Return the names of the runs, and a sentence on every file that is none."""
    patterns = {device.name: FilePattern(device.pattern) for device in devices if device.pattern}
    if not patterns:
        names = {PurePosixPath(device.files[0]).stem for device in devices}
        return [names.pop() if len(names) == 1 else "run1"], []
    everything = list(dict.fromkeys(file for device in devices for file in device.files))
    matches = {
        source: [(file, name) for file in everything if (name := pattern.run_of(file)) is not None]
        for source, pattern in patterns.items()
    }
    found: FoundFiles = files_of_runs(matches, patterns)
    remarks = [
        f'run "{entry.run}": {_named(list(entry.files.values()))} without '
        f"{' and '.join(patterns[source].text for source in entry.lacking)} of the same run: not used"
        for entry in found.unpartnered
    ]
    remarks += [
        f'run "{entry.run}": both {entry.files[0]} and {entry.files[1]} are a log of {entry.source}: move one away, or '
        "name all files of the run in [[runs]]"
        for entry in found.ambiguous
    ]
    for device in devices:
        own = patterns[device.name]
        stray = [file for file in device.files if own.run_of(file) is None]
        remarks += (
            [f"{_named(stray)}: not named as the other logs of {device.name}, {own.text}: not used"] if stray else []
        )
    return list(found.runs), remarks
