"""How long a search still takes, measured by what of it is done."""

from __future__ import annotations

import time
from collections.abc import Callable

LEAST_ELAPSED_S = 3.0
"""Seconds after which the time that is left is stated: earlier it is a guess."""
LEAST_DONE = 0.03
"""Share of what is to be done from which on the time that is left is stated: earlier it is a guess."""


def seconds_left(elapsed: float, share: float | None) -> str:
    """Return how long something still takes, in words, from the time so far and the share that is done; "" at first.

    Examples
    --------
    >>> seconds_left(10.0, 0.25), seconds_left(600.0, 0.5), seconds_left(1.0, 0.5), seconds_left(10.0, None)
    ('about 30 s left', 'about 10 min left', '', '')
    """
    if elapsed < LEAST_ELAPSED_S or share is None or not LEAST_DONE <= share < 1.0:
        return ""
    left = elapsed * (1.0 - share) / share
    return f"about {max(round(left), 1)} s left" if left < 90.0 else f"about {round(left / 60.0)} min left"


class TimeLeft:
    """How long something still takes, counted from where its share is first known: what was done before is no part.

    Examples
    --------
    >>> now = 0.0
    >>> left = TimeLeft(clock=lambda: now)
    >>> left.reached(None)
    >>> now = 60.0
    >>> left.reached(0.0)
    >>> now = 70.0
    >>> left.in_words(0.5)
    'about 10 s left'
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last: float | None = None
        self._began = clock(), 0.0

    def reached(self, share: float | None) -> None:
        """Take the share that is done; None where it is not known. A smaller one than before is of another step."""
        if share is not None and (self._last is None or share < self._last):
            self._began = self._clock(), share
        self._last = share

    def in_words(self, share: float | None) -> str:
        """Return how long the rest takes, as `seconds_left`; of what was done since the beginning."""
        began, first = self._began
        done = None if share is None or first >= 1.0 else (share - first) / (1.0 - first)
        return seconds_left(self._clock() - began, done)
