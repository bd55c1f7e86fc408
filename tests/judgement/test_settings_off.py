"""Settings that the readings contradict are named as such: no effect and no unlisted law stands for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.answers.setting_results import SettingKind
from stiffcal.identification.derivatives.observation import predicted, rests
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.judgement.numbers import CONTRADICTED, SETUP_MISTAKE
from stiffcal.judgement.priors import MemberKind, Share, log_odds
from stiffcal.judgement.reading import WhatIsMissing, read_off
from stiffcal.judgement.states import judge_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.field_mix import FieldCampaign, draw_campaign

SEED, NOTHING = 9002, 9
"""A campaign of positions with nothing hidden."""
HELD = "joint-compliance.j2.c"


@pytest.fixture(scope="module")
def campaign() -> FieldCampaign:
    return draw_campaign(SEED, NOTHING)


@pytest.fixture(scope="module")
def fit(campaign: FieldCampaign) -> Fit:
    return fitted(campaign.states, campaign.model)


def fitted(states: LoadStates, model: CompliantRobot) -> Fit:
    return fit_observations(fit_problem(states, model), model, Settings())


def said(states: LoadStates, model: CompliantRobot, held: frozenset[str] = frozenset()) -> WhatIsMissing:
    return read_off(judge_states(states, model, built_in_effects(), Settings(fixed=held)))


@pytest.mark.long
def test_a_parameter_that_is_held_at_a_wrong_value_is_named(campaign: FieldCampaign, fit: Fit) -> None:
    wrong = fit.robot.with_values({HELD: 1.5 * fit.robot.values()[HELD]})
    found = said(campaign.states, wrong, frozenset({HELD}))
    assert [(one.setting.kind, one.setting.name) for one in found.settings if one.probability > 0.99] == [
        (SettingKind.FIXED, HELD)
    ]
    assert found.groups == ()
    assert not found.unexplained
    assert found.p_nothing < 0.01


@pytest.mark.long
def test_a_parameter_that_is_held_at_its_value_is_not(campaign: FieldCampaign, fit: Fit) -> None:
    found = said(campaign.states, fit.robot, frozenset({HELD}))
    assert found.settings == ()
    assert found.p_nothing > 0.9


@pytest.mark.long
def test_a_wrench_that_acts_on_the_deformed_robot_contradicts_the_first_order_balance(campaign: FieldCampaign) -> None:
    found = said(campaign.states, replace(campaign.model, deformed=False))
    assert [one.setting.kind for one in found.settings if one.probability > 0.99] == [SettingKind.BALANCE]
    assert found.groups == ()


@pytest.mark.long
def test_a_tool_that_nobody_stated_is_named(campaign: FieldCampaign, fit: Fit) -> None:
    """Weight shows by what the robot gives: of positions ten times as exact a tool of half of the largest force."""
    data = fit.data
    assert data.setup.tool_mass == 0.0
    mass = 0.5 * float(np.abs(data.wrench[:3]).max()) / 9.81
    heavy = replace(data, setup=replace(data.setup, tool_mass=mass))
    plain, moved = (predicted(fit.robot, one, *rests(fit.robot, one)) for one in (data, heavy))
    position = campaign.states.position + (moved - plain - 0.9 * fit.residual).T[:, None]
    found = said(replace(campaign.states, position=position), campaign.model)
    assert [one.setting.kind for one in found.settings if one.probability > 0.9] == [SettingKind.TOOL]
    assert found.groups == ()


def test_all_settings_together_have_one_probability() -> None:
    setting = [Share(f"place {k}", "held", MemberKind.SETTING, False) for k in range(5)]
    odds = np.exp(log_odds([*setting, Share("tool", "tool", MemberKind.SETUP, False)]))
    assert np.sum(odds[:5] / (1.0 + odds[:5])) == pytest.approx(CONTRADICTED)
    assert odds[5] / (1.0 + odds[5]) == pytest.approx(SETUP_MISTAKE)
