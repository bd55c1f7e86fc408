"""Numbers that instruments and loggers write where there is no reading: -9999, 9999.99, -1e30, the end of an integer.

Such a number repeats exactly, where readings differ by noise, and lies far outside of everything else in its channel.
Its digits show what it is; where it is any other number, as -1000, its repeating among readings that never do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.campaign.signals.row_filter import condition_text
from stiffcal.quantities import Unit
from stiffcal.reduction.logs.frozen import RESTLESS

LEAST_NINES = 3  # 99 is a reading like others
BEYOND_ALL = 1e15  # in whatever unit: -1e30, ±1.8e308, 3.4e38
ENDS = {float(2**bits - one) for bits in (15, 16, 23, 24, 31, 32) for one in (0, 1)}
"""Of integers of converters and loggers."""
OTHERS = 5
"""Readings that have to be there besides: with which the number is compared."""
OUTSIDE, FAR_OUTSIDE = 1.0, 10.0
"""Ranges of all other readings between them and the number: where its digits say what it is, and where they do not."""
REPEATED = 3
"""Times at least that a number without such digits is read."""


@dataclass(frozen=True)
class FilledNumber:
    """A number in place of readings, in one channel of a batch."""

    number: float
    """In the unit of the file."""
    filled: Booleans
    """(n,) in which rows."""
    others: tuple[float, float]
    """Least and largest of the other readings, in the unit of the file."""

    def condition(self, column: str) -> str:
        """Return the condition on rows that leaves it out; a number of many digits may be rounded: a range instead."""
        if float(f"{self.number:.10g}") == self.number:
            return condition_text(column, "!=", self.number)
        below = self.number < self.others[0]
        between = 0.5 * (self.number + self.others[0 if below else 1])
        return condition_text(column, ">" if below else "<", float(f"{between:.2g}"))


def is_filled_in(number: float) -> bool:
    """Return whether a number's digits are those that are written where there is no reading.

    Examples
    --------
    >>> [is_filled_in(number) for number in (-9999.0, 9999.99, -1e30, 32767.0, 99.0, 998.9)]
    [True, True, True, True, False, False]
    """
    size = abs(number)
    if size >= BEYOND_ALL or size in ENDS:
        return True
    # seven digits are what a number of 32 bits has
    return any(
        len(digits) >= LEAST_NINES and set(digits) == {"9"}
        for digits in (f"{size:.{most}g}".replace(".", "") for most in (7, 12))
    )


def filled_number(
    values: Floats, low: float, high: float, before: tuple[float, float] | None, unit: Unit | None, changes: bool
) -> FilledNumber | None:
    """Return the number in place of readings that a channel holds, None where it holds none.

    Parameters
    ----------
    values : (n,) the channel's readings, SI. low, high : the least and the largest of them.
    before : the same of earlier batches, None of the first.
    unit : of the file; None: SI.
    changes : whether readings of such a channel differ by noise; else its digits alone make such a number known.
    """

    def written(value: float) -> float:
        in_file = value if unit is None else (value - unit.offset) / unit.factor
        return float(f"{in_file:.12g}")

    found: list[float] = []
    rest, ends = values, [low, high]
    for _ in range(4):  # a channel may hold two of them
        own = next((end for end in ends if np.isfinite(end) and is_filled_in(written(end))), None)
        if own is None:
            break
        found.append(own)
        rest = rest[rest != own]
        ends = [float(np.fmin.reduce(rest)), float(np.fmax.reduce(rest))] if rest.size else []
    known = bool(found)
    if not found and changes and values.size > REPEATED + OTHERS:
        found = [end for end in (low, high) if int((values == end).sum()) >= REPEATED]
    for own in found:
        others = rest if known else values[values != own]
        others = others[np.isfinite(others)]
        if others.size < OTHERS and before is None:
            continue
        least, most = _range(others, before if known and others.size < OTHERS else None)
        gap = max(least - own, own - most)
        if not gap > (OUTSIDE if known else FAR_OUTSIDE) * (most - least) > 0.0:
            continue
        if not known and np.count_nonzero(np.diff(others) == 0.0) >= RESTLESS * (others.size - 1):
            continue
        return FilledNumber(written(own), values == own, (written(least), written(most)))
    return None


def _range(values: Floats, before: tuple[float, float] | None) -> tuple[float, float]:
    ends = [*(before or ()), *([float(values.min()), float(values.max())] if values.size else [])]
    return min(ends), max(ends)
