"""Checks of the best set: sound campaigns pass them, noise that no set explains does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.judgement.checks import _LeftOver, checks_of
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.reading import read_off
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.states import judge_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.field_mix import FieldCampaign, draw_campaign

pytestmark = pytest.mark.long

SEED, NOTHING = 9002, 1
"""A campaign with nothing hidden and repeats of every load."""


@pytest.fixture(scope="module")
def campaign() -> FieldCampaign:
    return draw_campaign(SEED, NOTHING)


def judged(campaign: FieldCampaign, states: LoadStates) -> Judged:
    return judge_states(states, campaign.model, built_in_effects())


def test_squares_that_are_expected_are_the_readings_less_what_is_fitted(campaign: FieldCampaign) -> None:
    sound = judged(campaign, campaign.states)
    left = _LeftOver.of(sound)
    dof = sound.ground.noise.dof
    # nuisances with a proper prior take less than a reading each
    assert dof - len(sound.ground.shared.columns) < left.expected.sum() <= dof
    assert all(check.p_value > 0.003 for check in checks_of(sound))
    assert not read_off(sound).unexplained


@pytest.mark.practice
def test_a_run_of_three_times_the_noise_is_found(campaign: FieldCampaign) -> None:
    states, rng = campaign.states, np.random.default_rng(4)
    noise = judged(campaign, states).fit.noise
    assert isinstance(noise, Noise)
    run = int(states.run[len(states) // 2])
    more = 2.8 * noise.translation * rng.normal(size=states.position.shape)
    position = np.where((states.run == run)[:, None, None], states.position + more, states.position)
    found = read_off(judged(campaign, replace(states, position=position)))
    ((off, probability),) = found.doubted
    assert off == Off(run)
    assert probability > 0.999
    assert found.groups == ()
    assert not found.unexplained
