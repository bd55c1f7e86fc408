"""What was seen of a run's logs, but for its load states, as a JSON text and back; numbers come back to the last bit.

Why not `stiffcal.documents`: ten thousand of these are read in every command, NaN is a number here, and what anybody
else may have written is never read.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.ingest.quality.data_quality import FileHeader, ReadLog
from stiffcal.ingest.reading.read_run import ReadRun
from stiffcal.ingest.reading.run_tables import Widths, widths_of
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.reduction.logs.sampled_readings import SampledReadings
from stiffcal.reduction.logs.summary import ChannelRemark, LogSummary
from stiffcal.reduction.states.ingested_runs import UnusedData

Described = Callable[[str], tuple[bool, Mapping[str, tuple[str, ...]], Mapping[str, str]]]
"""From a source to what the summaries of its logs share, `DataQuality.described`."""


@dataclass(frozen=True)
class StoredText:
    """What is in the text of a run."""

    read: ReadRun
    """Without its states and its block averages."""
    widths: tuple[Widths, Widths]
    """Names and numbers of channels of its states' signals, and of their scatter."""
    blocks: tuple[str, ...]
    """The sources of which the store holds block averages."""


def text_of(read: ReadRun) -> str:
    """Return what reading a run gave as a text, without its states and its block averages."""
    logs = [
        [
            log.source,
            log.summary.file,
            log.summary.n_rows,
            [log.summary.interval, log.summary.first_s, log.summary.last_s, log.summary.longest],
            {signal: [low.tolist(), log.summary.high[signal].tolist()] for signal, low in log.summary.low.items()},
            [[remark.file, remark.text, remark.is_stuck] for remark in log.summary.channel_remarks],
            [[header.file, header.conflicts, header.remarks, header.at_once] for header in log.headers],
            _packed(log.summary.readings),
        ]
        for log in read.logs
    ]
    clocks = {
        source: [clock.value, clock.std, clock.reason, clock.rate, clock.rate_std, clock.rate_against]
        for source, clock in read.clocks.items()
    }
    dropped = [[own.state, own.why, own.code, own.pieces, own.seconds, own.first_s] for own in read.dropped]
    document = [logs, clocks, dropped, read.warnings, read.passes, widths_of(read.states), list(read.blocks)]
    return json.dumps(document, ensure_ascii=False, separators=(",", ":"))


def stored_text(text: str, described: Described) -> StoredText:
    """Return what is in a text that `text_of` made.

    Parameters
    ----------
    described : what the manifest states of a source.
    """
    logs, clocks, dropped, warnings, passes, widths, blocks = json.loads(text)
    read_logs = []
    for source, file, n_rows, (interval, first_s, last_s, longest), extremes, remarks, headers, readings in logs:
        sampled, columns, elsewhere = described(source)
        summary = LogSummary(
            file,
            sampled,
            columns,
            elsewhere,
            n_rows,
            interval,
            first_s,
            last_s,
            longest,
            {signal: np.array(ends[0], dtype=np.float64) for signal, ends in extremes.items()},
            {signal: np.array(ends[1], dtype=np.float64) for signal, ends in extremes.items()},
            tuple(ChannelRemark(*remark) for remark in remarks),
            _unpacked(readings),
        )
        of_files = tuple(
            FileHeader(own, tuple(conflicts), tuple(texts), at_once) for own, conflicts, texts, at_once in headers
        )
        read_logs.append(ReadLog(source, summary, of_files))
    read = ReadRun(
        "",
        tuple(read_logs),
        clocks={source: SourceClockOffset(*values) for source, values in clocks.items()},
        dropped=tuple(
            UnusedData(state=state, why=why, code=code, pieces=pieces, seconds=seconds, first_s=first)
            for state, why, code, pieces, seconds, first in dropped
        ),
        warnings=tuple(warnings),
        passes=passes,
    )
    means, scatter = (tuple((str(name), int(width)) for name, width in own) for own in widths)
    return StoredText(read, (means, scatter), tuple(blocks))


def _packed(readings: SampledReadings | None) -> tuple[object, str, str] | None:
    """Return readings as they are stored: numbers as bytes, which are read faster than digits."""
    if readings is None:
        return None
    scatter = readings.scatter.astype(np.float32)  # which needs no more digits
    return readings.layout, _text_of(readings.values.tobytes()), _text_of(scatter.tobytes())


def _text_of(numbers: bytes) -> str:
    return base64.b64encode(numbers).decode("ascii")


def _unpacked(stored: tuple[list[tuple[str, int]], str, str] | None) -> SampledReadings | None:
    if stored is None:
        return None
    layout, values, scatter = stored
    width = sum(count for _, count in layout)
    return SampledReadings(
        tuple((name, count) for name, count in layout),
        np.frombuffer(base64.b64decode(values), np.float64).reshape(-1, width),
        np.frombuffer(base64.b64decode(scatter), np.float32).reshape(-1, width).astype(np.float64),
    )
