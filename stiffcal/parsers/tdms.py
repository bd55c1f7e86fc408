"""TDMS logs: the channels of a group. npTDMS reads a file whose writer died up to where it goes: it is refused."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.log_columns import Options, damaged_file_errors, missing_library, nearest_name
from stiffcal.parsers.named_columns import NamedColumn, OpenColumns

LIBRARIES = ("nptdms",)
"""Imported before the limits of a log hold."""
UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")
WAVEFORM_TIME = "time"


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenColumns]:
    """Open a log.

    Raises
    ------
    InputError
        For a damaged file or one whose writer was interrupted, a group that is not there.
    """
    with _opened(path, display_name) as file:
        group = _group(file, options, display_name)
        yield OpenColumns(_columns(group), display_name, f"group {group.name}")


def tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose each group that has channels; the errors are those of `open_log`."""
    with _opened(path, display_name) as file:
        names = [group.name for group in file.groups() if group.channels()]
    return [{"group": name} for name in names] if len(names) > 1 else [{}]


@contextmanager
def _opened(path: Path, display_name: str) -> Iterator[Any]:
    try:
        from nptdms import TdmsFile
        from nptdms.log import log_manager
    except ImportError:
        raise missing_library("tdms", display_name) from None
    # What it logs of a damaged file is reported below, as a fault.
    log_manager.set_level(logging.CRITICAL)
    # Opened here, as the library lets go of no file that it cannot read, and by a path would read the index next to it.
    with (
        damaged_file_errors("TDMS file", display_name),
        open_regular(path, display_name) as raw,
        TdmsFile.open(raw) as file,
    ):
        _check_finished(file, display_name)
        yield file


def _columns(group: Any) -> dict[str, NamedColumn]:
    """Return the channels of a group, and the times of those that were written as waveforms."""
    channels: dict[str, Any] = {channel.name: channel for channel in group.channels()}
    columns = {name: NamedColumn(len(channel), _reader(channel), _unit(channel)) for name, channel in channels.items()}
    waveform = next((channel for channel in channels.values() if "wf_increment" in channel.properties), None)
    if waveform is not None and WAVEFORM_TIME not in columns and float(waveform.properties["wf_increment"]) > 0.0:
        columns[WAVEFORM_TIME] = NamedColumn(len(waveform), _times(waveform), "s")
    return columns


def _reader(channel: Any) -> Callable[[int, int], NDArray[Any]]:
    return lambda start, end: np.asarray(channel.read_data(start, end - start))


def _times(waveform: Any) -> Callable[[int, int], NDArray[np.float64]]:
    """Return what gives the times, s, of a waveform's rows: evenly spaced from an offset."""
    offset = float(waveform.properties.get("wf_start_offset", 0.0))
    step = float(waveform.properties["wf_increment"])
    return lambda start, end: np.asarray(offset + step * np.arange(start, end), dtype=np.float64)


def _check_finished(file: Any, display_name: str) -> None:
    status = file.file_status
    if not status.incomplete_final_segment and not status.channel_statuses:
        return
    reason = "the last segment is not complete: writing was interrupted, or the copy was cut off"
    for path, channel in (status.channel_statuses or {}).items():
        if channel.read_length < channel.expected_length:
            reason += f" (channel {path}: {channel.read_length} of {channel.expected_length} values of it)"
            break
    mend = "copy it again from its origin, or open and save it in DIAdem or LabVIEW and check the result"
    raise InputError.at(FaultCode.FILE_INCOMPLETE, display_name, "last segment", reason, mend)


def _group(file: Any, options: Options, display_name: str) -> Any:
    groups = {group.name: group for group in file.groups()}
    requested = options.get("group")
    if requested is not None:
        if requested not in groups:
            raise InputError.at(
                FaultCode.LOG_PART_MISSING,
                display_name,
                "tdms.group",
                f"no group {requested!r}",
                nearest_name(str(requested), list(groups)),
            )
        return groups[str(requested)]
    names = [name for name, group in groups.items() if group.channels()]
    if len(names) == 1:
        return groups[names[0]]
    if not names:
        raise InputError.at(
            FaultCode.FILE_EMPTY, display_name, "", "the file contains no channels", "log again, or leave the file out"
        )
    listed = ", ".join(repr(name) for name in names[:12])
    raise InputError.at(
        FaultCode.LOG_PART_AMBIGUOUS,
        display_name,
        "tdms.group",
        f"{len(names)} groups contain channels",
        f"state which: {listed}",
    )


def _unit(channel: Any) -> str:
    property_of: Callable[[str], Any] = channel.properties.get
    return next((str(property_of(key)).strip() for key in UNIT_PROPERTIES if property_of(key)), "")
