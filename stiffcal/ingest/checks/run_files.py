"""Files of runs: what was read of each, and which are not there yet."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from stiffcal.campaign.manifest.found_runs import nothing_found
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.results import (
    CheckedColumn,
    CheckedSource,
)

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.campaign.manifest.source import Source
    from stiffcal.ingest.quality.data_quality import DataQuality
    from stiffcal.reduction.logs.summary import LogSummary


def is_missing(fault: Fault) -> bool:
    """Return whether a fault is that a log is not there yet."""
    return fault.code is FaultCode.FILE_MISSING


def missing_files(campaign: Campaign, only: str | None, were_read: Collection[str]) -> list[str]:
    """Return one line for every file that is named and not there yet; those that were read need no look."""
    sentences, sources = [], campaign.manifest.sources
    homeless: dict[str, int] = {}  # a folder that is not there is reported once, not for each of its files

    def absent(files: Iterable[str]) -> list[str]:
        # os.path.exists as in `is_there`
        missing = [file for file in files if file not in were_read and not os.path.exists(f"{campaign.folder}/{file}")]  # noqa: PTH110
        for file in missing:
            parent = PurePosixPath(file).parent
            if not (campaign.folder / parent).is_dir():
                homeless[str(parent)] = homeless.get(str(parent), 0) + 1
        return [file for file in missing if str(PurePosixPath(file).parent) not in homeless]

    for entry in campaign.manifest.runs:
        if only in (None, entry.id):
            files = absent(entry.files[name] for name in entry.files if sources[name].in_files)
            sentences += [f"run {entry.id}: {', '.join(files)} not there yet"] if files else []
    for name in sources:
        if not sources[name].in_files:
            continue
        sentences += [
            f"source {name}: {file} not there yet" for file in absent(campaign.manifest.files_of(name).values())
        ]
    if only is None:
        sentences += [
            f"{place}: {reason}; {mend}" for place, reason, mend in nothing_found(campaign.manifest, campaign.found)
        ]
    return [
        f"folder {name}: not there yet, {count} files are named in it" for name, count in homeless.items()
    ] + sentences


def files_of(campaign: Campaign, quality: DataQuality) -> list[CheckedSource]:
    """Return the summaries of the files as they were read."""
    sources = {name: campaign.manifest.sources[name] for name, _, _ in quality.logs}
    units = {
        name: {
            column: unit.name
            for signal in source.signals().values()
            for column, unit in signal.columns_with_units().items()
        }
        for name, source in sources.items()
    }
    return [_file(name, sources[name], units[name], log) for (name, _, _), log in quality.logs.items()]


def _file(name: str, source: Source, units: Mapping[str, str], log: LogSummary) -> CheckedSource:
    """Return the summary of a file; units are those in which its columns are written."""
    checked = []
    for signal, low in log.low.items():
        high, columns = log.high[signal], log.columns.get(signal, ())
        if signal == "wrench" and source.wrench is not None and source.wrench.direction is not None:
            low, high = _along(source.wrench.direction, low, high)
        checked += [
            CheckedColumn(
                signal=signal,
                column=column,
                unit=units.get(column, ""),
                low_si=finite_number(least),
                high_si=finite_number(most),
                moved=most > least,
            )
            for column, least, most in zip(columns, low.tolist(), high.tolist(), strict=False)
        ]
    return CheckedSource(
        source=name,
        file=log.file,
        rows=log.n_rows,
        rate_hz=finite_number(1.0 / log.interval if log.interval > 0.0 else None),
        span_s=finite_number(log.last_s - log.first_s),
        longest_gap_s=finite_number(log.longest),
        columns=checked,
        sampled=log.sampled,
    )


def _along(direction: Sequence[float], low: Any, high: Any) -> tuple[Any, Any]:
    """Return the ends of a force along a line, named by the component that it makes most of."""
    import numpy as np

    unit = np.array(direction) / np.linalg.norm(direction)
    most = int(np.argmax(np.abs(unit)))
    ends = sorted((low[most] / unit[most], high[most] / unit[most]))
    return np.array(ends[:1]), np.array(ends[1:])


def finite_number(value: Any) -> float | None:
    """Return a finite float, or None."""
    return float(value) if value is not None and math.isfinite(value) else None
