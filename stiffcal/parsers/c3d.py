"""C3D files: markers, or channels, frame by frame. ezc3d holds the whole file in memory."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import open_regular
from stiffcal.limits import COLUMNS
from stiffcal.log_columns import Batch, Options, WantedColumns, batch_of_columns, damaged_file_errors, missing_library
from stiffcal.parsers.open_log import OpenLog

LIBRARIES = ("ezc3d",)
"""Imported before the limits of a log hold."""
TIME = "time"
BLOCK = 512
"""Bytes by which the format counts where its parts begin."""
BIG_ENDIAN = b"\x56"
"""Of a processor, as the format names them."""


class OpenC3d(OpenLog):
    """The markers or channels of an open file."""

    def __init__(self, columns: Sequence[tuple[str, str]], values: Floats, rate: float, display_name: str) -> None:
        self.columns = (TIME, *(name for name, _ in columns))
        self.units = {TIME: "s", **{name: unit for name, unit in columns if unit}}
        self.n_rows = values.shape[1]
        self.display_name, self.place = display_name, "labels"
        self._values, self._rate = values, rate

    def batches(self, wanted: WantedColumns) -> Iterator[Batch]:
        """Yield the frames in batches.

        Raises
        ------
        InputError
            For a file without frames, a marker that is out of sight where no gaps are allowed.
        """
        n_rows = self._values.shape[1]
        if n_rows == 0:
            raise InputError.at(FaultCode.FILE_EMPTY, self.display_name, "", "no frames", "log again")
        at = {name: self.columns.index(name) - 1 for name in wanted.names}

        def read(name: str, start: int, end: int) -> Floats:
            return np.arange(start, end) / self._rate if at[name] < 0 else self._values[at[name], start:end]

        for start in range(0, n_rows, self.BATCH_ROWS):
            yield batch_of_columns(read, wanted, start, min(start + self.BATCH_ROWS, n_rows), self.display_name)


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenC3d]:
    """Open a log.

    Raises
    ------
    InputError
        For a damaged file, one without the wanted kind of data or without their rate.
    """
    try:
        import ezc3d
    except ImportError:
        raise missing_library("c3d", display_name) from None
    analog = options.get("data") == "analog"
    with damaged_file_errors("C3D file", display_name):
        head = _head(path, display_name)
        log = ezc3d.c3d(str(path))
        _check_whole(head, log, display_name)
        group = log["parameters"]["ANALOG" if analog else "POINT"]
        labels = _labels(group)
        if analog:
            values = np.asarray(log["data"]["analogs"])[0]
            units = _words(group, "UNITS")
            columns = list(zip(labels, [*units, *[""] * len(labels)], strict=False))
        else:
            values = _points(log)
            unit = next(iter(_words(group, "UNITS")), "")
            columns = [(f"{label} {axis}", unit) for label in labels for axis in "XYZ"]
        rate = float(np.ravel(group["RATE"]["value"])[0])
    COLUMNS.check(len(columns), display_name)
    kind = "channels" if analog else "markers"
    if not columns or len(columns) != len(values):
        reason = f"{len(labels)} labels for {len(values) if analog else len(values) // 3} {kind}"
        mend = 'choose the other with c3d = { data = "points" } or "analog", or export it again'
        raise InputError.at(FaultCode.FILE_EMPTY, display_name, "labels", reason, mend)
    if not (np.isfinite(rate) and rate > 0.0):
        raise InputError.at(FaultCode.FILE_DAMAGED, display_name, "", f"the rate is {rate} Hz", "export it again")
    yield OpenC3d(columns, values, rate, display_name)


def tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose the markers and the channels, where there are both; errors as of `open_log`."""
    found: list[Options] = []
    for options in ({}, {"data": "analog"}):
        with suppress(InputError), open_log(path, options, display_name) as log:
            found += [options] if log.n_rows else []
    return found or [{}]


def _head(path: Path, display_name: str) -> bytes:
    """Return the beginning of a file; `ValueError` where it is none of C3D: the library would read any sizes there."""
    with open_regular(path, display_name) as file:
        head = file.read(BLOCK * 255)
    if len(head) < BLOCK or head[1:2] != b"\x50" or len(head) <= BLOCK * (head[0] - 1) + 3 or not head[0]:
        raise ValueError("it does not begin like C3D")
    return head


def _check_whole(head: bytes, log: Any, display_name: str) -> None:
    """Raise an `InputError` where fewer frames were read than the file states: the library takes what is there."""
    block = head[BLOCK * (head[0] - 1) :]
    order = ">" if block[3:4] == BIG_ENDIAN else "<"
    first, last = struct.unpack_from(f"{order}HH", head, 6)
    trial = log["parameters"].get("TRIAL", {})
    if "ACTUAL_END_FIELD" in trial:  # the words above hold 65535 frames at most
        low, high = (int(word) & 0xFFFF for word in np.ravel(trial["ACTUAL_END_FIELD"]["value"])[:2])
        last = max(last, low + (high << 16))
    found = np.asarray(log["data"]["points"]).shape[2] or np.asarray(log["data"]["analogs"]).shape[2]
    if found < last - first + 1:
        reason = f"{found} frames where its head states {last - first + 1}: it was cut off"
        mend = "copy it again from its origin, or export it again"
        raise InputError.at(FaultCode.FILE_INCOMPLETE, display_name, "", reason, mend)


def _points(log: Any) -> Floats:
    """Return (3 m, n) coordinates of m markers, NaN where one was out of sight."""
    points = np.array(log["data"]["points"], dtype=np.float64)[:3]
    points[:, np.asarray(log["data"]["meta_points"]["residuals"])[0] < 0.0] = np.nan
    return points.transpose(1, 0, 2).reshape(-1, points.shape[2])


def _labels(head: Any) -> list[str]:
    """Return the labels, of which a parameter holds 255 at most: the others stand in LABELS2 and so on."""
    names = ["LABELS", *sorted(name for name in head if name.startswith("LABELS") and name[6:].isdecimal())]
    labels = [label for name in names for label in _words(head, name)]
    return labels[: int(np.ravel(head["USED"]["value"])[0])]


def _words(head: Any, name: str) -> list[str]:
    return [str(word).strip() for word in head[name]["value"]] if name in head else []
