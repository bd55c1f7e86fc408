"""What could not be excluded: of half of the stated size an effect is not found, of twice the size it is."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.judgement.excluded import _squares_to_find, excluded_sizes
from stiffcal.judgement.reading import read_off
from stiffcal.judgement.states import judge_states
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.field_mix import draw_campaign

SEED, NOTHING = 9002, 9
"""A campaign of positions with nothing hidden."""
PLACE = "base"


@pytest.mark.practice
def test_an_effect_is_found_from_about_the_stated_size_on() -> None:
    campaign, catalogue = draw_campaign(SEED, NOTHING), built_in_effects()
    judged = judge_states(campaign.states, campaign.model, catalogue)
    size = next(one.size for one in excluded_sizes(judged) if one.where == PLACE)
    assert 1e-7 < size < 1e-4
    member = next(one for one in judged.members if one.share.place == PLACE)
    # what its turns make, alike, of this size at the tool
    moved = np.sum([judged.ground.space.unwhitened(row) for row in member.columns.rows[3:]], axis=0)
    moved *= size / np.sqrt(np.sum(moved**2) / moved.shape[1])
    for times, found in ((0.25, False), (2.5, True)):
        states = replace(campaign.states, position=campaign.states.position + times * moved.T[:, None])
        named = read_off(judge_states(states, campaign.model, catalogue)).groups
        assert any(name.startswith("base-compliance") for group in named for name, _ in group.members) is found


def test_more_squares_are_needed_of_what_is_less_probable() -> None:
    likely, unlikely = _squares_to_find(np.log(0.1)), _squares_to_find(np.log(1e-4))
    assert likely < unlikely
    root = np.sqrt(likely) - 1.2816
    assert root**2 == pytest.approx(-2.0 * np.log(0.1) + np.log1p(likely))


@pytest.mark.parametrize(("stated", "places"), [([0], ["joint 1"]), ([], [])])
def test_no_size_is_stated_of_what_is_not_read_in_its_unit(stated: list[int], places: list[str]) -> None:
    """Of a clamped motor's angle alone "0 m at the tool" was stated."""
    rows, place = np.ones((1, 4)), "joint 1"
    member = SimpleNamespace(
        candidate=object(), share=SimpleNamespace(place=place), columns=SimpleNamespace(rows=rows), log_prior=-3.0
    )
    left = [SimpleNamespace(gram=[rows @ rows.T], square=np.ones(1))]
    noise = SimpleNamespace(scale=lambda squares: squares)
    evidence = SimpleNamespace(left_by=lambda key: left, noise=noise)
    data = SimpleNamespace(measured_mask=np.ones((1, 4), dtype=np.bool_))
    space = SimpleNamespace(data=data, unwhitened=lambda row: row[None])
    ground = SimpleNamespace(stated=np.array(stated, dtype=np.int64), space=space)
    judged: Any = SimpleNamespace(weighed=SimpleNamespace(evidence=evidence, best=()), ground=ground, members=[member])
    assert [one.where for one in excluded_sizes(judged)] == places
