"""Times as logs have them, words or a clock's steps, as seconds since 1970-01-01 UTC."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

_PER_SECOND = {"W": 1 / 604800, "D": 1 / 86400, "h": 1 / 3600, "m": 1 / 60, "s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}

_LARGEST = 9e12  # the year 287 000: no log's, but what becomes of a database's infinity


def seconds_of_times(texts: Sequence[str], display_name: str, name: str, first_row: int) -> NDArray[np.float64]:
    """Return ISO 8601 times as seconds since 1970-01-01 UTC (without a zone: taken as UTC).

    Parameters
    ----------
    texts : n times, such as ``2026-11-21T08:15:30.250Z`` or ``2026-11-21 08:15:30,25+01:00``.

    Raises
    ------
    InputError
        At the first that is none.

    Examples
    --------
    >>> seconds_of_times(["1970-01-02T00:00:00.5Z", "1970-01-02 01:00:01+01:00"], "log.csv", "t", 1)
    array([86400.5, 86401. ])
    """
    seconds = np.empty(len(texts))
    epoch = datetime(1970, 1, 1, tzinfo=UTC)
    for index, text in enumerate(texts):
        try:
            seconds_text, nanoseconds = _split_fraction(text.strip())
            moment = datetime.fromisoformat(seconds_text)
        except ValueError:
            raise InputError.at(
                FaultCode.NUMBER_INVALID,
                display_name, f"row {first_row + index}, column {name}", f"{text!r} is not an ISO 8601 time",
                "write times like 2026-11-21T08:15:30.250Z, or give the column's unit as s, ms, us or ns",
            ) from None  # fmt: skip
        elapsed = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)) - epoch
        seconds[index] = elapsed.days * 86400 + elapsed.seconds + nanoseconds
    return seconds


def _split_fraction(text: str) -> tuple[str, float]:
    """Return the time without its decimal fraction, and that in seconds: any number of digits, point or comma."""
    if len(text) < 10 or not text[:4].isdigit():
        raise ValueError(text)
    for mark in ".,":
        head, separator, tail = text.partition(mark)
        if separator:
            digits = len(tail) - len(tail.lstrip("0123456789"))
            if not digits:
                raise ValueError(text)
            return head + tail[digits:], float("0." + tail[:digits])
    return text, 0.0


def seconds_of_timestamps(moments: NDArray[Any]) -> NDArray[np.float64]:
    """Return moments (n,) of any step as seconds; what is none as NaN, what a database calls infinite so.

    Examples
    --------
    >>> seconds_of_timestamps(np.array(["1970-01-02T00:00:00.5", "NaT"], dtype="datetime64[us]"))
    array([86400.5,     nan])
    """
    unit, count = np.datetime_data(moments.dtype)
    if unit not in _PER_SECOND:  # months and years are of no one length
        unit, count, moments = "s", 1, moments.astype("datetime64[s]")
    steps = moments.astype(np.int64)
    seconds = steps * float(count) / _PER_SECOND[unit]
    return np.where(np.isnat(moments), np.nan, np.where(np.abs(seconds) > _LARGEST, np.inf, seconds))
