"""Weight that the robot file does not state: how the readings change with it, and that no effect is named for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.derivatives.observation import predicted, rests
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.judgement.priors import MemberKind, Share, log_odds
from stiffcal.judgement.reading import read_off
from stiffcal.judgement.states import judge_states
from stiffcal.judgement.weight import WeightOfLinks
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.field_mix import draw_campaign

SEED, UNKNOWN_MASSES = 3, 227
"""A campaign played by MuJoCo with nothing hidden, of a robot whose links have masses that the model does not know."""


def test_a_mass_at_the_centre_of_a_link_is_the_sum_of_mass_and_moment() -> None:
    campaign = draw_campaign(SEED, UNKNOWN_MASSES)
    fit = fit_observations(fit_problem(campaign.states, campaign.model), campaign.model, Settings())
    weight, link = WeightOfLinks.of(fit.robot, fit.data), 3
    name, columns = weight.of_links[link]
    mass, centre = 20.0, np.array([0.1, -0.2, 0.3])
    chain = fit.robot.chain
    masses, centres = chain.link_mass.copy(), chain.link_com.copy()
    masses[link], centres[link] = mass, centre
    heavier = replace(fit.robot, chain=replace(chain, link_mass=masses, link_com=centres))
    change = predicted(heavier, fit.data, *rests(heavier, fit.data)) - predicted(
        fit.robot, fit.data, *rests(fit.robot, fit.data)
    )
    expected = np.tensordot(mass * np.array([1.0, *centre]), columns, axes=1)
    assert name == chain.link_names[link]
    # second order: what the weight turns the links by, some milliradians
    np.testing.assert_allclose(change, expected, atol=0.01 * np.abs(change).max())


@pytest.mark.long
def test_no_effect_is_named_for_the_weight_of_a_robot_whose_masses_are_not_stated() -> None:
    campaign = draw_campaign(SEED, UNKNOWN_MASSES)
    found = read_off(judge_states(campaign.states, campaign.model, built_in_effects()))
    assert campaign.hidden == ()
    assert not campaign.model.chain.masses_known
    assert found.groups == ()
    assert found.p_nothing > 0.9


def test_a_place_where_no_effect_is_listed_has_a_quarter_of_the_others() -> None:
    effect = Share("link arm", "link-beam", MemberKind.EFFECT, True)
    law, alone = (Share(f"link {name}", "weight", MemberKind.UNLISTED, True) for name in ("arm", "hand"))
    odds = np.exp(log_odds([effect, law, alone]))
    expected = odds / (1.0 + odds)
    assert expected[1] == pytest.approx(expected[2])
    assert expected[0] == pytest.approx(3.0 * expected[1])
