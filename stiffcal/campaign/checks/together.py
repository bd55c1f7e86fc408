"""What can only be checked with manifest, robot, model and folder together."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Iterator
from difflib import get_close_matches
from itertools import chain, islice
from pathlib import Path, PurePosixPath

from stiffcal.campaign.checks.absolute_checks import absolute_faults
from stiffcal.campaign.checks.column_checks import column_faults
from stiffcal.campaign.checks.frame_checks import frame_faults
from stiffcal.campaign.checks.prismatic_checks import prismatic_faults
from stiffcal.campaign.checks.run_checks import MOST_COMPARED, MOST_LOOKED_FOR, exclusion_faults, run_faults
from stiffcal.campaign.checks.source_checks import signal_faults, source_faults
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.thresholds import strange_joints
from stiffcal.campaign.model.model_file import MODEL_FILE, ModelFile
from stiffcal.campaign.robot.robot_checks import RobotOutline
from stiffcal.campaign.signals.signals import (
    JointSignals,
)
from stiffcal.campaign.toml.explain import key_path
from stiffcal.campaign.toml.name_checks import odd_character
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import PlainFiles, escapes, link_fault, links_outside
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import check_regular

MOST_NAME = 255
"""Bytes of one name, which no file system exceeds."""


def manifest_faults(manifest: Manifest, links: tuple[str, ...] | None) -> list[Fault]:
    """Check a manifest in itself.

    Parameters
    ----------
    manifest : as read.
    links : names that the robot's links go by; None where the robot could not be read.
    """
    faults = chain(
        frame_faults(manifest, links),
        run_faults(manifest),
        source_faults(manifest),
        signal_faults(manifest, links),
        column_faults(manifest),
        exclusion_faults(manifest),
        absolute_faults(manifest),
    )
    return list(islice(faults, MOST_LOOKED_FOR))


def robot_match_faults(manifest: Manifest, outline: RobotOutline, robot_file: str) -> list[Fault]:
    """Check joint columns, nominal joints and moved joints against the robot's joints."""
    joint_names = outline.joint_names
    faults = list(prismatic_faults(manifest, joint_names, outline.prismatic))
    count = len(joint_names)
    for source, name, signal in manifest.signals():
        if not isinstance(signal, JointSignals):
            continue
        for key, columns in signal.groups().items():
            if len(columns) != count:
                place = f"sources.{source}.{name}.{key}"
                reason = f"{len(columns)} columns, but {robot_file} has {count} joints"
                mend = f"name one column per joint: {', '.join(joint_names)}"
                if len(columns) < count:
                    mend += (
                        "; for a joint that was not logged and did not move, begin or end the chain at its link "
                        '(base_link, tip_link), or make its type "fixed" in the URDF'
                    )
                faults.append(_fault(FaultCode.JOINT_COUNT, place, reason, mend))
        constants = signal.torque_constant
        if constants is not None and len(constants) not in (1, count):
            reason = f"{len(constants)} constants, but {robot_file} has {count} joints"
            faults.append(
                _fault(
                    FaultCode.JOINT_COUNT,
                    f"sources.{source}.{name}.torque_constant",
                    reason,
                    "write one, or one per joint",
                )
            )
    for number, run in enumerate(manifest.runs):
        place = f"runs[{number + 1}] ({run.id})"
        if run.joints_deg is not None and len(run.joints_deg) != count:
            reason = f"{len(run.joints_deg)} angles, but {robot_file} has {count} joints"
            faults.append(_fault(FaultCode.JOINT_COUNT, f"{place}.joints_deg", reason, "write one angle per joint"))
        if run.moved_joint is not None and run.moved_joint > count:
            reason = f"joint {run.moved_joint}, but the robot has {count} joints"
            faults.append(_fault(FaultCode.JOINT_UNKNOWN, f"{place}.moved_joint", reason, f"write 1 to {count}"))
    for key, name in strange_joints(manifest.thresholds, joint_names):
        faults.append(
            _fault(
                FaultCode.JOINT_UNKNOWN,
                f"thresholds.{key}.{name}",
                "there is no such joint",
                "use " + ", ".join(joint_names),
            )
        )
    return faults


def model_match_faults(model: ModelFile, joint_names: tuple[str, ...], links: tuple[str, ...]) -> list[Fault]:
    """Check the model's places against the robot."""
    faults = []
    count = len(joint_names)
    for number, entry in enumerate(model.effects):
        place = f"effects[{number + 1}] ({entry.type})"
        for key, joints in (("joints", entry.joints or ()), ("pairs", [j for pair in entry.pairs or () for j in pair])):
            wrong = [joint for joint in joints if joint > count]
            if wrong:
                reason = f"joint {wrong[0]}, but the robot has {count} joints"
                faults.append(
                    Fault(FaultCode.JOINT_UNKNOWN, MODEL_FILE, f"{place}.{key}", reason, f"write 1 to {count}")
                )
        for name in entry.links or ():
            if name not in links:
                mend = "use one of " + ", ".join(links) if links else "name the links in robot.toml"
                faults.append(
                    Fault(FaultCode.LINK_UNKNOWN, MODEL_FILE, f"{place}.links", f'the robot has no link "{name}"', mend)
                )
    return faults


def file_faults(manifest: Manifest, folder: Path, *, must_exist: bool) -> list[Fault]:
    """Check every path in the manifest: inside the campaign folder, and there."""
    faults: list[Fault] = []
    absent: dict[str, list[tuple[str, str]]] = {}
    named_files = {file for _, file, _ in _paths(manifest)}
    run_tables = {"runs": [{"id": run.id} for run in manifest.runs]}
    plain = PlainFiles(folder)
    for location, file, fetched in _paths(manifest):
        if len(faults) >= MOST_LOOKED_FOR:
            break
        if fetched and file in plain and odd_character(file) is None:  # as nearly all are
            continue
        place = key_path(location, run_tables)
        if wrong := odd_character(file):
            faults.append(_fault(FaultCode.NAME_INVALID, place, *wrong))
        elif any(len(os.fsencode(name)) > MOST_NAME for name in PurePosixPath(file).parts):
            faults.append(
                _fault(FaultCode.NAME_INVALID, place, f"a file name of more than {MOST_NAME} bytes", "rename the file")
            )
        elif escapes(file):
            mend = "use a file inside the campaign folder, given by its relative path"
            faults.append(_fault(FaultCode.FILE_OUTSIDE, place, f'"{file}" lies outside the campaign folder', mend))
        elif leading := links_outside(folder, file):
            faults.append(link_fault(MANIFEST_FILE, place, *leading[0]))
        elif fetched and must_exist and not (folder / file).exists():
            if (folder / file).parent.is_dir():
                faults.append(
                    _fault(
                        FaultCode.FILE_MISSING, place, f"no such file: {file}", _file_advice(folder, file, named_files)
                    )
                )
            else:
                absent.setdefault(str(PurePosixPath(file).parent), []).append((place, file))
        elif fetched:
            faults += _special(folder, file, place)
    for name, missing in absent.items():  # one line for a folder, not one for each of its files
        place, file = missing[0]
        if len(missing) == 1:
            mend = f"there is no folder {name} either; add the file"
            faults.append(_fault(FaultCode.FILE_MISSING, place, f"no such file: {file}", mend))
        else:
            reason = f"no such folder: {name}; {len(missing)} files are expected in it, {file} first"
            faults.append(_fault(FaultCode.FILE_MISSING, place, reason, "put the files there"))
    return faults


def _special(folder: Path, file: str, place: str) -> Iterator[Fault]:
    """Yield the fault of a file that is no regular one: a pipe would let its reader wait for ever."""
    try:
        check_regular(folder / file, file)
    except InputError as error:
        for fault in error.faults:
            yield _fault(fault.code, place, f'"{file}": {fault.reason}', fault.mend)
    except (OSError, ValueError):  # not there, or not to be reached: reported where it is opened
        return


def _file_advice(folder: Path, file: str, named_files: set[str]) -> str:
    """Suggest a file of nearly the same name, unless the manifest names it elsewhere."""
    wanted = folder / file
    named_paths = {folder / named_file for named_file in named_files}
    names = sorted(path.name for path in wanted.parent.iterdir() if path not in named_paths)
    if any(unicodedata.normalize("NFC", name) == unicodedata.normalize("NFC", wanted.name) for name in names):
        return "the name of the existing file uses another Unicode form (NFD, as on macOS): rename it"
    suggestions = get_close_matches(wanted.name, names[:MOST_COMPARED], n=1)
    return f'did you mean "{suggestions[0]}"?' if suggestions else "add it, or correct the name"


def _paths(manifest: Manifest) -> Iterator[tuple[tuple[int | str, ...], str, bool]]:
    """Yield (place, path, whether it is read as a file) of everything that names a file."""
    yield ("robot",), manifest.robot, False  # its absence is found when it is read
    for name, source in manifest.sources.items():
        if not source.in_files:
            continue
        if source.own_file is not None:
            yield ("sources", name, "file"), source.own_file, True
        elif source.file is not None:  # the pattern of each run's file
            yield ("sources", name, "file"), source.file, False
        for signal, file in source.files.items():
            yield ("sources", name, "files", signal), file, True
    for number, run in enumerate(manifest.runs):
        for name, file in run.files.items():
            known = manifest.sources.get(name)
            if known is not None and known.pattern is not None:
                yield ("sources", name, "file"), file, True
            elif known is None or known.in_files:
                yield ("runs", number, "files", name), file, True
        if run.states is not None:
            yield ("runs", number, "states"), run.states, True
    for number, file in enumerate(manifest.plugins):
        yield ("plugins", number), file, True
    if manifest.report.logo is not None:
        yield ("report", "logo"), manifest.report.logo, True


def _fault(code: FaultCode, place: str, reason: str, mend: str, *names: str) -> Fault:
    return Fault(code, MANIFEST_FILE, place, reason, mend, names)
