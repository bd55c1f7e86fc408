"""Campaigns whose truth is known: what is missing is named, and where nothing is, nothing is."""

from __future__ import annotations

import pytest

from tests.rates.practice import HIDDEN, ask, truth
from tests.whole_campaigns.conftest import of_suite

# 01 is diagnosed for the fingerprint, and 08 hides nothing either; 02: in test_hidden_robots and absolute/02 bearings
# tilt; 05 and 11: the joint of joints/04 has both a curve and a wave.
ELSEWHERE = ("01", "02", "05", "11")


@pytest.mark.parametrize("folder", of_suite(sorted(truth()), *ELSEWHERE))
def test_names_what_is_hidden(folder: str) -> None:
    answer = ask(HIDDEN / folder)
    assert answer.right, f"{answer.hidden or 'nothing'} is hidden, {answer.named or 'nothing'} is named"
    if not answer.outside:
        # Within five per cent of the noise once it is added.
        assert answer.after < 1.05


def test_campaigns_are_whole() -> None:
    assert len(truth()) == 12
    for folder in truth():
        assert (HIDDEN / folder / "raw" / "states.csv").is_file()
