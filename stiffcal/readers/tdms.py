"""TDMS logs, as National Instruments' LabVIEW, DIAdem and FlexLogger write them. Needs the extra ``tdms`` (npTDMS).

Options of the manifest (``tdms = {…}``):

group : the group that holds the channels; may be left out where one group alone has any.

Columns are the group's channels. Channels that were written as waveforms carry no times but a step: their times are to
be had as a column ``time`` (s from the waveform's start), unless a channel has that name. Units come from the property
``unit_string`` (or ``NI_UnitDescription``). Scalings that are stored with a channel are applied.

npTDMS reads a file whose writer died up to where it goes: such a file is refused, as are channels of unequal length.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import COLUMNS, ROWS
from stiffcal.readers import (
    Batch,
    FuzzInput,
    Header,
    Options,
    Reader,
    WantedColumns,
    batch_of_columns,
    check_columns,
    check_options,
    check_there,
    common_length,
    damaged_file_errors,
    missing_library,
    nearest_name,
)

BATCH_ROWS = 1 << 16
UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")
WAVEFORM_TIME = "time"
FEW_SCALINGS = 100  # of a channel, or values in the table of one


class TdmsOptions(TomlTable):
    """Where in a TDMS file the channels lie: the group; may be left out where only one group has any."""

    group: Name | None = None


def _write_fuzz_input(path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    columns = {"t": np.linspace(0.0, 0.6, 60), "Fx": np.arange(-30.5, 29.0)}
    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("ft", name, values) for name, values in columns.items()])


class TdmsReader(Reader):
    """Reads TDMS files in batches of rows."""

    name = "tdms"
    endings = (".tdms",)
    first_bytes = b"TDSm"
    options = TdmsOptions
    fuzz_inputs = (FuzzInput(".tdms", _write_fuzz_input, ("t", "Fx")),)

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the channels of the group."""
        display_name = display_name or str(path)
        with _open_channels(path, options, display_name) as (channels, place):
            if wanted is not None:
                check_columns(wanted, tuple(channels), display_name, place)
            lengths = {_length(channel) for channel in channels.values()}
            units = {name: unit for name, channel in channels.items() if (unit := _unit(name, channel))}
            return Header(tuple(channels), units, lengths.pop() if len(lengths) == 1 else None)

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield the rows in batches.

        Raises
        ------
        InputError
            For a damaged file or one whose writer was interrupted, a missing channel, channels of unequal length, a
            channel that holds no numbers, a number that is not finite.
        """
        display_name = display_name or str(path)
        with _open_channels(path, options, display_name) as (channels, place):
            check_columns(wanted, tuple(channels), display_name, place)
            n_rows = common_length({name: _length(channel) for name, channel in channels.items()}, wanted, display_name)
            ROWS.check(n_rows, display_name)

            def read(name: str, start: int, end: int) -> NDArray[Any]:
                channel = channels[name]
                if isinstance(channel, _Waveform):
                    return channel.times(start, end)
                with damaged_file_errors("TDMS file", display_name):
                    return np.asarray(channel.read_data(start, end - start))

            for start in range(0, n_rows, BATCH_ROWS):
                yield batch_of_columns(read, wanted, start, min(start + BATCH_ROWS, n_rows), display_name)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"


READER = TdmsReader()


class _Waveform:
    """The times of channels that were written as waveforms: evenly spaced from an offset."""

    def __init__(self, channel: Any) -> None:
        self.n_rows = len(channel)
        self._offset = float(channel.properties.get("wf_start_offset", 0.0))
        self._step = float(channel.properties["wf_increment"])

    def times(self, start: int, end: int) -> NDArray[np.float64]:
        """Return seconds of rows `start` to before `end`."""
        return np.asarray(self._offset + self._step * np.arange(start, end), dtype=np.float64)


@contextmanager
def _open_channels(path: Path, options: Options, display_name: str) -> Iterator[tuple[Mapping[str, Any], str]]:
    """Open a file; yield the channels of its group by name, and ``group NAME``, the place of faults in them."""
    check_options(options, TdmsOptions, "tdms", display_name)
    check_there(path, display_name)
    try:
        from nptdms import TdmsFile
        from nptdms.log import log_manager
    except ImportError:
        raise missing_library("tdms", display_name) from None
    # Opened here, as the library lets go of no file that it cannot read.
    with open_regular(path, display_name) as raw:
        with damaged_file_errors("TDMS file", display_name):
            # What it logs of a damaged file is reported below, as a fault.
            log_manager.set_level(logging.CRITICAL)
            file = TdmsFile.open(raw)
        with file:
            _check_finished(file, display_name)
            with damaged_file_errors("TDMS file", display_name):
                group = _group(file, options, display_name)
                _check_scalings((file, group, *group.channels()), display_name)
                COLUMNS.check(len(group.channels()), display_name, f"group {group.name}")
                channels = _channels(group)
            yield channels, f"group {group.name}"


def _channels(group: Any) -> dict[str, Any]:
    channels: dict[str, Any] = {channel.name: channel for channel in group.channels()}
    waveform = next((channel for channel in channels.values() if "wf_increment" in channel.properties), None)
    if waveform is not None and WAVEFORM_TIME not in channels and float(waveform.properties["wf_increment"]) > 0.0:
        channels[WAVEFORM_TIME] = _Waveform(waveform)
    return channels


def _check_scalings(items: Iterable[Any], display_name: str) -> None:
    """Refuse a number of scalings, or of values in one, that no property follows: the library counts up to it."""
    for item in items:
        most = max(FEW_SCALINGS, len(item.properties))
        for name, value in item.properties.items():
            counts = name == "NI_Number_Of_Scales" or (name.startswith("NI_Scale[") and name.endswith("_Size"))
            if counts and not (isinstance(value, int | np.integer) and 0 <= value <= most):
                reason = f"the property {name} is {value!r}, but there are no such scalings"
                raise InputError.at(
                    FaultCode.FILE_DAMAGED,
                    display_name,
                    str(getattr(item, "path", "/")),
                    reason,
                    "write the scaled values",
                )


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


def _length(channel: Any) -> int:
    return channel.n_rows if isinstance(channel, _Waveform) else len(channel)


def _unit(name: str, channel: Any) -> str:
    if isinstance(channel, _Waveform):
        return "s"
    property_of: Callable[[str], Any] = channel.properties.get
    return next((str(property_of(key)).strip() for key in UNIT_PROPERTIES if property_of(key)), "")
