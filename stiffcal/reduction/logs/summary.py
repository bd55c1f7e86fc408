"""What is known of a log, once it was read to its end: what a campaign's logs are compared by, and its warnings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.reduction.logs.sampled_readings import SampledReadings

SATURATED = 20  # readings in a row at the very same extreme


@dataclass(frozen=True)
class ChannelRemark:
    """What may be wrong with a log or a channel of it."""

    file: str
    text: str
    is_stuck: bool = False
    """True where a channel stands still or is stuck."""


@dataclass(frozen=True)
class LogSummary:
    """What was seen of the rows and channels of one log."""

    file: str
    """The file as the user named it."""
    sampled: bool
    """False where rows are load states."""
    columns: Mapping[str, tuple[str, ...]]
    """Signal to the columns' names in the file."""
    elsewhere: Mapping[str, str]
    """Signal to its own file, where a source lies in several files."""
    n_rows: int
    interval: float
    """The usual time from reading to reading, s; NaN where there is one reading."""
    first_s: float
    """The first reading's time, s; NaN where the log has no clock."""
    last_s: float
    """The last one's."""
    longest: float
    """Longest interval between two rows, s."""
    low: Mapping[str, Floats]
    """Signal to the least value of each channel, SI."""
    high: Mapping[str, Floats]
    """Signal to the largest value of each channel, SI."""
    channel_remarks: tuple[ChannelRemark, ...] = ()
    """Gaps, channels that stand still next to moving ones, saturation."""
    readings: SampledReadings | None = None
    """Some of its readings; None where it holds none of what instruments measure."""

    def remarks(self) -> list[str]:
        """Return the warnings on the log and its channels."""
        return [f"{remark.file}: {remark.text}" for remark in self.channel_remarks]

    def still_channels(self) -> list[ChannelRemark]:
        """Return those of the remarks that are of channels that stand still or are stuck."""
        return [remark for remark in self.channel_remarks if remark.is_stuck]

    def dead(self) -> list[int]:
        """Return the channels of the wrench that read zero all through the log, and nothing else."""
        if "wrench" not in self.low or self.n_rows <= SATURATED:
            return []
        return [int(k) for k in np.flatnonzero((self.low["wrench"] == 0.0) & (self.high["wrench"] == 0.0))]

    def dead_channel_remark(self, k: int) -> str:
        """Return the warning on a dead channel that is alive in other logs."""
        column = column_of_channel(self.columns, "wrench", k)
        return (
            f"{self.elsewhere.get('wrench', self.file)}: {column} reads 0 throughout, unlike in other logs; it is used "
            "as it is: check the sensor, or exclude this run"
        )


def column_of_channel(columns: Mapping[str, tuple[str, ...]], signal: str, k: int) -> str:
    """Return how a channel of a signal is called in messages.

    Examples
    --------
    >>> column_of_channel({"wrench": ("Fx", "Fy")}, "wrench", 1), column_of_channel({}, "wrench", 1)
    ('column Fy', 'channel 2 of wrench')
    """
    names = columns.get(signal, ())
    return f"column {names[k]}" if k < len(names) else f"channel {k + 1} of {signal}"
