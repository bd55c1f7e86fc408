"""Campaigns whose truth is known: what is missing is named, and where nothing is, nothing is."""

from __future__ import annotations

import pytest

from tests.laboratory.practice_marks import with_practice
from tests.rates.practice import HIDDEN, ask, truth

# An effect of the catalogue where only positions were measured. 01 is diagnosed for the fingerprint, 09, whose effect
# is in no catalogue, for docs/how-to/own-effect-proposed.md; in test_hidden_robots nothing is hidden, or two effects at
# once.
HERE = ("03",)


@pytest.mark.parametrize("folder", with_practice(sorted(truth()), *HERE))
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
