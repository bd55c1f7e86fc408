"""Gaps in the times of a log: no readings for a while, or a clock that was set.

A clock that is set forward leaves a gap, as lost readings do. Either explanation has one lag and one linear map for
all readings of both logs, so that what each explains decides: the times as they are, or with the gap closed. Without
that comparison the one lag falls where half of the logs agree by chance: loads along +x, +y, +z, −x, −y, −z agree with
themselves half a cycle away, with the other sign.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.reduction.clocks.lag_search import CoarseLag, SharedSignal, coarse_lag, interval_of

JUMP_S = 1.0  # from one block to the next: a pause, or a clock that was set; pieces of a run show less (`course`)
# In log-likelihood: readings of logs are not white, so that a share decides and not a number. A gap that moves some
# readings by a second or more leaves their ramps unexplained.
CLEARLY_MORE = 1.1


class Gap(NamedTuple):
    """The longest time from one block of a log to the next."""

    length: float
    """s."""
    before: float
    """When it ends, s on the log's clock."""


def longest_gap(time: Floats) -> Gap:
    """Return the longest gap of times (n,), s.

    Examples
    --------
    >>> import numpy as np
    >>> longest_gap(np.array([0.0, 0.5, 4.5, 5.0]))
    Gap(length=4.0, before=4.5)
    """
    step = np.diff(time)
    if step.size == 0:
        return Gap(0.0, 0.0)
    longest = int(step.argmax())
    return Gap(float(step[longest]), float(time[longest + 1]))


def set_in_a_gap(first: SharedSignal, second: SharedSignal, lag: CoarseLag) -> str:
    """Return in words that the clock of one of two logs was set in its longest gap, or "".

    Parameters
    ----------
    first, second : the logs. lag : of the second, at which it follows the first best with the times as they are.
    """
    for closed, one, other in _closed(first, second):
        closed_lag = coarse_lag(one, other)
        if not isinstance(closed_lag, str) and closed_lag.gain > CLEARLY_MORE * lag.gain:
            return (
                f"its clock was set: with the gap before {longest_gap(closed.time).before:.1f} s in the times of "
                f"{closed.source} closed, {second.source} follows {first.source} far better"
            )
    return ""


def _closed(first: SharedSignal, second: SharedSignal) -> Iterator[tuple[SharedSignal, SharedSignal, SharedSignal]]:
    """Yield each log that has a gap, and both logs with this gap closed."""
    for signal in (second, first):
        gap, usual = longest_gap(signal.time), interval_of(signal.time)
        if gap.length - usual <= JUMP_S:
            continue
        after = signal.time >= gap.before
        shorter = replace(signal, time=signal.time - (gap.length - usual) * after)
        yield (signal, first, shorter) if signal is second else (signal, shorter, second)
