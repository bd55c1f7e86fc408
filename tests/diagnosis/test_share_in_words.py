"""The share of the error that goes with the missing effects, in words: verb by number, no interval of one point."""

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
    (0.996, 0.998, 1.001, "99.6 to 100.1 %"), (0.9, 0.95, 0.97, "90 to 97 %"), (0.9954, 0.999, 1.0, "99.5 to 100 %"),
    (0.9998, 0.9999, 1.0, "at least 99.9 %"), (1.0, 1.0, 1.0, "at least 99.9 %"),
])  # fmt: skip
def test_ends_that_would_be_printed_alike_have_another_digit(low: float, share: float, high: float, ends: str) -> None:
    text = share_in_words(search(low, share, high))
    assert f"{100 * share:.0f} % (95 %: {ends})" in text
