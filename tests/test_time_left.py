"""The time that is left is counted from where the share is known, over what was done since."""

from __future__ import annotations

import pytest

from stiffcal.presentation.time_left import TimeLeft


@pytest.mark.parametrize(
    ("calls", "left"),
    [
        ([(0.0, 0.0), (10.0, 0.25)], "about 30 s left"),
        # what was done before a share was known is no part of it
        ([(0.0, None), (60.0, 0.05)], ""),
        ([(0.0, None), (60.0, 0.0), (70.0, 0.5)], "about 10 s left"),
        ([(0.0, 0.0), (10.0, 0.4), (20.0, None), (60.0, 0.4), (70.0, 0.5)], "about 50 s left"),
        # another step begins
        ([(0.0, 0.0), (60.0, 0.9), (61.0, 0.1), (71.0, 0.55)], "about 10 s left"),
        ([(0.0, 0.0), (10.0, 1.0)], ""),
        ([(0.0, 1.0), (10.0, 1.0)], ""),
    ],
)
def test_time_is_counted_from_the_first_known_share(calls: list[tuple[float, float | None]], left: str) -> None:
    now = 0.0
    of = TimeLeft(clock=lambda: now)
    for now, share in calls:  # noqa: B007
        of.reached(share)
    assert of.in_words(calls[-1][1]) == left
