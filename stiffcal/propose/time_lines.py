"""The line of a log's time: its column, or the rate."""

from __future__ import annotations

from itertools import pairwise

from stiffcal.campaign.columns.column_headers import is_unit_of
from stiffcal.campaign.columns.column_words import DATES, words_of
from stiffcal.campaign.manifest.source import TIMES_IN_WORDS
from stiffcal.escapes import toml_text
from stiffcal.propose.lines import ProposedLine
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.quantities import unit


def time_line(
    time: SniffedColumn | None, rate_hz: float | None, fraction: tuple[SniffedColumn, str] | None = None
) -> ProposedLine | None:
    """Return the line of a log's time: its column, or the rate where the column stands still; None without both.

    Parameters
    ----------
    time : the column; None where there is none. rate_hz : as the log states it, where it does.
    fraction : the column of what is added to it, and its unit.
    """
    if time is not None and (rate_hz is None or fraction is not None or not stands_still(time)):
        written, is_guessed = unit_of_time(time)
        added = {} if fraction is None else {"fraction": fraction[0].header, "fraction_unit": fraction[1]}
        line = toml_text.pair("time", {"column": time.header, "unit": written} | added)
        guessed = f"{written}, judged by the values (up to {time.size:.10g})"
        guessed += ", as spreadsheets count days from 1900" if written == _DAYS else ""
        return ProposedLine(line, guessed if is_guessed else time.doubt)
    if rate_hz is None:
        return None
    why = "as stated in its first lines"
    if time is not None:
        why += f"; {time.header} repeats values: its resolution is lower than the rate"
    return ProposedLine(f"time = {{ rate_hz = {rate_hz:g} }}", why)


def unit_of_time(time: SniffedColumn) -> tuple[str, bool]:
    """Return the unit of a column of times, and whether it was guessed by the size of its values."""
    known = time.unit in TIMES_IN_WORDS or (time.unit is not None and is_unit_of(time.unit, "time"))
    written = str(time.unit) if known else _likely_time_unit(time)
    return (written if written in TIMES_IN_WORDS else unit(written, "time").name), not known


_DAYS = "day"
_DAY_NUMBERS = (36526.0, 73050.0)
"""Of 2000 and of 2100, as spreadsheets count days."""
_FASTEST_S = 1e-4
"""Shorter steps of a column that is not called a date, taken as seconds, are days: nobody logs so fast."""


def _likely_time_unit(time: SniffedColumn) -> str:
    """Return the unit of a time without one: seconds, but where they count from 1970 in finer steps, or are days."""
    size = time.size
    if len(time.values) > 1 and _DAY_NUMBERS[0] <= min(time.values) <= size < _DAY_NUMBERS[1]:
        step = sorted(later - earlier for earlier, later in pairwise(time.values))[(len(time.values) - 1) // 2]
        named = any(word in DATES for word in words_of(time.name)[0])
        if step > 0.0 and (named or step < _FASTEST_S):
            return _DAYS
    finer = [name for name, least in (("ns", 1e17), ("us", 1e14), ("ms", 1e11)) if size > least]
    return finer[0] if finer else "s"


def stands_still(time: SniffedColumn) -> bool:
    """Return whether a column of times gives no order of the rows, rounded to the same value as it is."""
    return any(later <= earlier for earlier, later in pairwise(time.values))
