"""The share of the error that goes with what is missing, in words: verb by number, no interval of one point."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.diagnosis.document import share_in_words


def search(low: float, share: float, high: float, found: int = 1) -> Any:
    """Return a search that found so many effects, which explain this share."""
    explained = SimpleNamespace(low=low, share=share, high=high)
    return SimpleNamespace(found=[None] * found, tried=[None], after=object(), explained=explained)


def test_the_verb_follows_the_number_of_effects() -> None:
    assert share_in_words(search(0.9, 0.95, 0.97)).startswith("explains ")
    assert share_in_words(search(0.9, 0.95, 0.97, found=2)).startswith("explain ")
    assert share_in_words(search(0.1, 0.2, 0.3, found=0)).startswith("explains ")


@pytest.mark.parametrize(("low", "share", "high", "ends"), [
    (0.996, 0.998, 1.001, 0), (0.9, 0.95, 0.97, 2), (0.996, 0.99, 0.999, 2),
])  # fmt: skip
def test_no_interval_between_two_equal_ends(low: float, share: float, high: float, ends: int) -> None:
    text = share_in_words(search(low, share, high))
    assert f"{100 * share:.0f} %" in text
    assert [f"{100 * low:.0f} to {100 * high:.0f} %" in text] == [ends == 2]
