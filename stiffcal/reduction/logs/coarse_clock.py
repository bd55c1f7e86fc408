"""A time column that ticks more slowly than rows come: the same time over several rows, then a step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats

LEAST_TICKS = 8
"""Ticks below which their length is not judged."""
REGULAR = 0.9
"""Share of ticks that hold the usual number of rows, give or take one: below it rows are missing, or do not come
evenly."""


@dataclass(frozen=True)
class CoarseClock:
    """A clock that shows the same time over several rows."""

    tick_s: float
    """From one shown time to the next, s."""
    rows_per_tick: float
    """How many rows show the same time, on average."""

    @property
    def rate_hz(self) -> float:
        """Rows per second."""
        return self.rows_per_tick / self.tick_s


def coarse_clock(time: Floats) -> CoarseClock | None:
    """Return the ticks of a time column, None where rows do not share times evenly.

    Parameters
    ----------
    time : (n,) s, rows in order; the first and the last tick may be cut.

    Examples
    --------
    >>> import numpy as np
    >>> clock = coarse_clock(0.016 * (np.arange(700) // 7))
    >>> round(clock.tick_s, 6), clock.rows_per_tick, round(clock.rate_hz, 6)
    (0.016, 7.0, 437.5)
    """
    starts = np.flatnonzero(np.diff(time, prepend=-np.inf) != 0.0)
    if starts.size < LEAST_TICKS + 2 or not (np.diff(time) >= 0.0).all():
        return None
    rows, steps = np.diff(starts)[1:], np.diff(time[starts])[1:]
    if np.median(rows) < 2:
        return None
    regular = (np.abs(rows - np.median(rows)) <= 1) & (np.abs(steps / np.median(steps) - 1.0) < 0.5)
    if regular.mean() < REGULAR:
        return None
    return CoarseClock(float(steps.mean()), float(rows.mean()))
