"""What a log cannot be: looked at batch by batch while it streams past (physics, section 0).

Faults stop: time that runs backwards, a displacement of a metre, an angle of 90 rad, a force of 3·10⁵ N, quaternions
that are none. Gaps, channels that stand still and saturation are remarked on: they may be meant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.campaign.signals.row_filter import condition_text
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.quantities import Unit
from stiffcal.quantity import DELAY
from stiffcal.reduction.logs.coarse_clock import coarse_clock
from stiffcal.reduction.logs.filled_numbers import FilledNumber, filled_number
from stiffcal.reduction.logs.frozen import FrozenChannels
from stiffcal.reduction.logs.reading_bounds import first_impossible
from stiffcal.reduction.logs.sampled_readings import ReadingSampler
from stiffcal.reduction.logs.summary import SATURATED, ChannelRemark, LogSummary, column_of_channel
from stiffcal.wording import count, in_unit, listing, significant

GAP = 10.0  # times the usual interval
MOST_GAPS = 3  # that are listed one by one
WHOLE = -1  # in place of a channel: all of a position
MOST_STRETCHES = 5  # of rows that are named
HOUR_S = 3600.0  # what daylight saving takes or gives
DAY_S = 86400.0  # what midnight takes from a time of day

_PLACES = ("position", "marker")
_NOISY = (*_PLACES, "wrench", "lengths", "displacement")
"""Signals whose readings differ by noise from one to the next."""


@dataclass
class LogQuality:
    """Collects, batch by batch, what is remarkable about the rows and channels of one log."""

    file: str
    """The file as the user named it."""
    place_of_row: Callable[[int], str]
    """Row to ``line n``."""
    sampled: bool
    """False where rows are load states."""
    columns: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Signal to the columns' names in the file."""
    elsewhere: Mapping[str, tuple[str, Callable[[int], str]]] = field(default_factory=dict)
    """Signal to its own file and row to ``line n``, where a source lies in several files."""
    slides: frozenset[str] = frozenset()
    """Columns that hold positions of prismatic joints."""
    declared: Mapping[str, Unit] = field(default_factory=dict)
    """Column to its unit, as the manifest states it."""
    by_the_wall: bool = False
    """True where times are dates, which may be local ones."""
    sampler: ReadingSampler | None = None
    """Takes readings by which the log is compared with others; None: it is compared with none."""
    n_rows: int = 0
    first_s: float = float("nan")
    last_s: float = float("nan")
    intervals: list[float] = field(default_factory=list)
    """Median interval between rows of every batch, s."""
    longest: float = 0.0
    """Longest interval between two rows, s."""
    longest_at: float = float("nan")
    """Time at which it ends, s."""
    n_gaps: int = 0
    low: dict[str, Floats] = field(default_factory=dict)
    """Signal to the least value of each channel, SI."""
    high: dict[str, Floats] = field(default_factory=dict)
    """Signal to the largest value of each channel, SI."""
    at_high: dict[str, NDArray[np.int64]] = field(default_factory=dict)
    """Signal to how often each channel read its largest value."""
    gaps: list[tuple[float, float]] = field(default_factory=list)
    """Begin and end of gaps, s."""
    frozen: dict[tuple[str, int], FrozenChannels] = field(default_factory=dict)
    """Signal and channel (`WHOLE`: all of a position) to the rows over which it did not change."""

    def update(self, number: NDArray[np.int64], time: Floats, signals: dict[str, Floats]) -> None:
        """Look at a batch: rows' numbers (n,), time (n,) s, signals name to (c, n) in SI.

        Raises
        ------
        InputError
            With the line of the first reading that cannot be.
        """
        if number.size == 0:
            return
        self.n_rows += int(number.size)
        if self.sampler is not None:
            self.sampler.update(signals)
        if self.sampled:
            self._update_time(number, time)
        for name, values in signals.items():
            with np.errstate(invalid="ignore"):
                low, high = np.fmin.reduce(values, axis=1), np.fmax.reduce(values, axis=1)
            if self.sampled:
                self._check_lost(name, number, values)
            self._check_filled(name, number, values, low, high)
            self._update_extremes(name, values, low, high)
            self._check_bounds(name, number, values, low, high)
            if self.sampled:
                self._update_frozen(name, number, values)

    def _update_time(self, number: NDArray[np.int64], time: Floats) -> None:
        """Take a batch's times (n,), s, into account; raise `InputError` where time stands still or runs backwards."""
        before = np.concatenate([[self.last_s], time[:-1]])
        step = time - before
        if not np.nanmin(step, initial=np.inf) > 0.0:
            k = int(np.flatnonzero(step <= 0.0)[0])
            text = "does not advance" if step[k] == 0.0 else "decreases"
            resumed = np.flatnonzero(time[k:] > before[k])
            last = int(number[k + int(resumed[0]) - 1] if resumed.size else number[-1])
            rows = f"row {number[k]}" if last == number[k] else f"rows {number[k]}-{last}"
            mend = f"exclude {rows} with [[exclude]], or remove repeated or misplaced rows in a copy of the log"
            if self._is_hour(step[k]):
                text, mend = "goes back by an hour", _WALL
            elif self._is_midnight(before[k], step[k]):
                text, mend = "starts anew at midnight", _MIDNIGHT
            reason = f"time {text}: {time[k]:.10g} s after {before[k]:.10g} s"
            ticks = coarse_clock(time) if step[k] == 0.0 else None
            if ticks is not None:
                reason = (
                    f"the time resolution is {in_unit(ticks.tick_s, DELAY.usual)}, with "
                    f"{ticks.rows_per_tick:.3g} rows per step"
                )
                mend = f"if rows are equally spaced, write time = {{ rate_hz = {ticks.rate_hz:.6g} }} for this source"
            raise InputError.at(FaultCode.TIME_ORDER, self.file, self.place_of_row(int(number[k])), reason, mend)
        ahead = np.flatnonzero(self._is_hour(step))
        if ahead.size:
            reason = "time jumps by an hour from one reading to the next"
            raise InputError.at(
                FaultCode.TIME_ORDER, self.file, self.place_of_row(int(number[ahead[0]])), reason, _WALL
            )
        if np.isnan(self.first_s):
            self.first_s, step, time = float(time[0]), step[1:], time[1:]
        if step.size:
            self.intervals.append(float(np.median(step[:4096])))
            wide = np.flatnonzero(step > GAP * self.interval)
            self.gaps += [(float(time[k] - step[k]), float(time[k])) for k in wide[: MOST_GAPS - len(self.gaps)]]
            self.n_gaps += wide.size
            k = int(np.argmax(step))
            if step[k] > self.longest:
                self.longest, self.longest_at = float(step[k]), float(time[k])
            self.last_s = float(time[-1])
        else:
            self.last_s = self.first_s

    def _is_hour(self, step: Floats) -> NDArray[np.bool_]:
        """Return where a date is an hour off, within a few usual intervals, as where clocks are set to summer time."""
        return np.asarray(self.by_the_wall & (np.abs(np.abs(step) - HOUR_S) < self._slack))

    def _is_midnight(self, before: float, step: float) -> bool:
        """Return whether a time of day without a date starts anew, within a few usual intervals of a day."""
        return bool(before <= DAY_S and abs(step + DAY_S) < self._slack)

    @property
    def _slack(self) -> float:
        """A few usual intervals, s, and what is usual for a logger where none is known yet."""
        return max(10.0 * self.interval, 1.0) if self.intervals else 10.0

    def _check_lost(self, name: str, number: NDArray[np.int64], values: Floats) -> None:
        """Refuse a target whose three components are one number, as zero or -9999: filled in where it was lost.

        Raises
        ------
        InputError
            With the line of the first such reading.
        """
        if name.split(".")[0] not in _PLACES or len(values) != 3:
            return
        filled = (values == values[0]).all(axis=0)
        if not filled.any():
            return
        first = int(filled.argmax())
        column = next(iter(self.columns.get(name, ("X",))), "X")
        factor = self.declared[column].factor if column in self.declared else 1.0
        number_read = float(f"{values[0, first] / factor:.12g}")
        shown = "zero" if number_read == 0.0 else f"{number_read:g}"
        reason = f"the position is {shown} in all columns ({int(filled.sum())} rows near here): the target was lost"
        condition = toml_text.pair("rows", condition_text(column, "!=", number_read))
        mend = f"exclude such rows: {condition} next to columns or position"
        self._fail(name, int(number[first]), reason, mend)

    def _check_filled(self, name: str, number: NDArray[np.int64], values: Floats, low: Floats, high: Floats) -> None:
        """Refuse a number that was written where there was no reading.

        Parameters
        ----------
        name : the signal. number : (n,) the rows' numbers in the log. values : (c, n) the batch, SI.
        low, high : (c,) least and largest value of each channel in the batch.

        Raises
        ------
        InputError : with the line of the first such number, columns, rows, and the condition that leaves them out.
        """
        kind, names = name.split(".")[0], self.columns.get(name, ())
        if kind in ("quaternion", *(() if self.sampled else _PLACES)):
            return
        found: dict[str, FilledNumber] = {}
        for k, column in enumerate(names[: len(values)]):
            before = (self.low[name][k], self.high[name][k]) if name in self.low else None
            own = filled_number(
                values[k], low[k], high[k], before, self.declared.get(column), self.sampled and kind in _NOISY
            )
            if own is not None and not any((own.filled <= other.filled).all() for other in found.values()):
                found[column] = own
        if not found:
            return
        column, own = next(iter(found.items()))
        rows = number[np.logical_or.reduce([one.filled for one in found.values()])]
        low_read, high_read = own.others
        reason = (
            f"{'column ' if len(found) == 1 else 'columns '}{listing(list(found))}: {own.number:.10g} in {rows.size} "
            f"row{'s' * (rows.size > 1)} ({_stretches(rows)}) where all others are "
            f"{significant(low_read, 4)} to {significant(high_read, 4)}: "
            "a number that was written where there was no reading"
        )
        condition = toml_text.pair("rows", " and ".join(one.condition(column) for column, one in found.items()))
        mend = f"leave such rows out: {condition} next to the names of the columns"
        self._fail(name, int(rows[0]), reason, mend)

    def _update_frozen(self, name: str, number: NDArray[np.int64], values: Floats) -> None:
        """Look for readings that stop changing: of a target all components together, then each by itself."""
        kind = name.split(".")[0]
        if kind not in _NOISY:
            return
        if kind in _PLACES:
            self.frozen.setdefault((name, WHOLE), FrozenChannels()).update(number, values)
        for k in range(len(values)):
            self.frozen.setdefault((name, k), FrozenChannels()).update(number, values[k : k + 1])

    def _update_extremes(self, name: str, values: Floats, low: Floats, high: Floats) -> None:
        """Widen the channels' extremes by those of a batch (c, n), and count readings in a row at one of them."""
        if name not in self.low:
            self.low[name], self.high[name] = low, high
        else:
            self.low[name], self.high[name] = np.fmin(self.low[name], low), np.fmax(self.high[name], high)
        if name == "wrench" and self.sampled:
            counts = self.at_high.setdefault(name, np.zeros(low.size, dtype=np.int64))
            for end, extreme in ((low, self.low[name]), (high, self.high[name])):
                for k in np.flatnonzero((end == extreme) & (low != high)):
                    counts[k] = max(counts[k], _longest_row(values[k] == end[k]))

    def _check_bounds(
        self, name: str, row_numbers: NDArray[np.int64], values: Floats, low: Floats, high: Floats
    ) -> None:
        """Refuse a reading that no robot or instrument can give.

        Parameters
        ----------
        name : the signal.
        row_numbers : (n,) the rows' numbers in the log.
        values : (c, n) the batch, SI.
        low, high : (c,) least and largest value of each channel in the batch.

        Raises
        ------
        InputError : with the line of the first such reading.
        """
        units = {column: declared.name for column, declared in self.declared.items()}
        impossible = first_impossible(name, values, low, high, self.columns.get(name, ()), self.slides, units)
        if impossible is not None:
            self._fail(name, row_numbers[impossible.row], impossible.reason, impossible.mend)

    def _fail(self, signal: str, number: int, reason: str, mend: str) -> None:
        file, place_of_row = self.elsewhere.get(signal, (self.file, self.place_of_row))
        raise InputError.at(FaultCode.READING_IMPLAUSIBLE, file, place_of_row(int(number)), reason, mend)

    @property
    def interval(self) -> float:
        """The usual time from reading to reading, s; NaN where there is one reading."""
        return float(np.median(self.intervals)) if self.intervals else float("nan")

    def summary(self) -> LogSummary:
        """Return what was seen of the whole log, with the warnings on it."""
        return LogSummary(
            self.file,
            self.sampled,
            self.columns,
            {signal: file for signal, (file, _) in self.elsewhere.items()},
            self.n_rows,
            self.interval,
            self.first_s,
            self.last_s,
            self.longest,
            self.low,
            self.high,
            tuple(self._remarks()),
            None if self.sampler is None else self.sampler.readings(),
        )

    def _remarks(self) -> list[ChannelRemark]:
        """Return the warnings on the log and its channels."""
        remarks: list[ChannelRemark] = []
        file, _ = self.elsewhere.get("wrench", (self.file, self.place_of_row))
        if self.sampled and self.longest > GAP * self.interval:
            where = ", ".join(f"{begin:.3f} … {end:.3f} s" for begin, end in self.gaps)
            suffix = f" and {self.n_gaps - len(self.gaps)} more" if self.n_gaps > len(self.gaps) else ""
            text = (
                f"a gap of {significant(self.longest)} s before {self.longest_at:.3f} s "
                f"(usual interval {significant(self.interval)} s; all: {where}{suffix}); gaps are not "
                f"filled, a dwell is the "
                "mean of the available readings"
            )
            remarks.append(ChannelRemark(self.file, text))
        is_constant = self.high.get("wrench", np.zeros(0)) == self.low.get("wrench", np.zeros(0))
        if is_constant.any() and not is_constant.all() and self.n_rows > SATURATED:
            for k in np.flatnonzero(is_constant & (self.high["wrench"] != 0.0)):
                text = f"{column_of_channel(self.columns, 'wrench', int(k))} is constant at {self.high['wrench'][k]:g}"
                remarks.append(ChannelRemark(file, text, is_stuck=True))
        ends = np.flatnonzero(self.at_high.get("wrench", np.zeros(0, dtype=np.int64)) >= SATURATED)
        stuck = {key: watch for key, watch in self.frozen.items() if watch.frozen}
        # of a target that stopped as a whole each component did
        stuck = {key: watch for key, watch in stuck.items() if key[1] == WHOLE or (key[0], WHOLE) not in stuck}
        remarks += [self._end_remark(int(k), stuck.pop(("wrench", int(k)), None)) for k in ends]
        return remarks + [self._frozen_remark(name, channel, watch) for (name, channel), watch in stuck.items()]

    def _end_remark(self, k: int, watch: FrozenChannels | None) -> ChannelRemark:
        file, place = self.elsewhere.get("wrench", (self.file, self.place_of_row))
        column, times = column_of_channel(self.columns, "wrench", k), int(self.at_high["wrench"][k])
        ends = (self.low["wrench"][k], self.high["wrench"][k])
        if watch is None or watch.value is None or float(watch.value[0]) not in ends:
            text = (
                f"{column} stays at its extreme for {times} readings: saturated? they are used as they are: exclude "
                "them with [[exclude]], or the run"
            )
        else:
            text = f"{column} stays at its extreme over {_rows(watch, place)}: saturated? {_AS_THEY_STAND}"
        return ChannelRemark(file, text)

    def _frozen_remark(self, name: str, k: int, watch: FrozenChannels) -> ChannelRemark:
        file, place = self.elsewhere.get(name, (self.file, self.place_of_row))
        target = k == WHOLE
        position = f"the position ({', '.join(self.columns.get(name, ()))})"
        channel_text = position if target else column_of_channel(self.columns, name, k)
        end = "the target was lost, or the tracker stopped" if target else "the channel was stuck"
        text = f"{channel_text} does not change over {_rows(watch, place)}: {end}; {_AS_THEY_STAND}"
        return ChannelRemark(file, text, is_stuck=True)


def _rows(watch: FrozenChannels, place: Callable[[int], str]) -> str:
    """Return how long a row of equal readings is and where: places in the file, and rows as [[exclude]] counts them."""
    first, last = watch.first, watch.last
    return f"{watch.longest} readings, {place(first)} to {place(last)} (rows {first}-{last})"


def _stretches(rows: NDArray[np.int64]) -> str:
    """Return rows' numbers, ascending, as [[exclude]] counts them: 21, 30-34."""
    parts = np.split(rows, np.flatnonzero(np.diff(rows) != 1) + 1)
    named = [f"{own[0]}" if own.size == 1 else f"{own[0]}-{own[-1]}" for own in parts[:MOST_STRETCHES]]
    more = len(parts) - len(named)
    return ", ".join(named) + (f" and {count(more, 'stretch', 'stretches')} more" if more else "")


_AS_THEY_STAND = "they are used as they are: exclude these rows with [[exclude]], or keep them"
_WALL = (
    "probably daylight saving time: log UTC, or write the zone with every time (2026-10-25T02:30:00+02:00), "
    "or correct the times in a copy"
)
_MIDNIGHT = "log dates with the times (2026-11-21T23:59:59.98), or add a day to all times after it in a copy of the log"


def _longest_row(row: NDArray[np.bool_]) -> int:
    """Return the longest run of True."""
    if not row.any():
        return 0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]])))
    return int((edges[1::2] - edges[::2]).max())
