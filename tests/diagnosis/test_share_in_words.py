"""The share of the error that goes with the missing effects, in words: verb by number, no interval of one point."""

from __future__ import annotations

import pytest

from stiffcal.diagnosis.scans.explained import Explained
from stiffcal.diagnosis.share_in_words import share_in_words


def words(low: float, share: float, high: float, n_effects: int = 1) -> str:
    """Return the words for a share and its interval."""
    return share_in_words(Explained(share, low, high, 1.0), n_effects, True)


def test_the_verb_follows_the_number_of_effects() -> None:
    assert words(0.9, 0.95, 0.97).startswith("explains ")
    assert words(0.9, 0.95, 0.97, n_effects=2).startswith("explain ")


@pytest.mark.parametrize(("low", "share", "high", "ends"), [
    (0.996, 0.998, 1.001, "99.6 to 100.1 %"), (0.9, 0.95, 0.97, "90 to 97 %"), (0.9954, 0.999, 1.0, "99.5 to 100 %"),
    (0.9998, 0.9999, 1.0, "at least 99.9 %"), (1.0, 1.0, 1.0, "at least 99.9 %"),
])  # fmt: skip
def test_ends_that_would_be_printed_alike_have_another_digit(low: float, share: float, high: float, ends: str) -> None:
    assert f"{100 * share:.0f} % (95 %: {ends})" in words(low, share, high)
