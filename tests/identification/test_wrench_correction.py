"""Wrenches as noisy as a play is narrow: its band is as wide as it is, not as wide as it reads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.identify import Settings, fit_observations, fit_problem
from stiffcal.identification.readings import WrenchCorrection
from stiffcal.identification.wrench_correction import WHOLE_PASSES, step_of, wrench_correction
from stiffcal.model.catalogue import built_in_effects
from stiffcal.model.composite import PlacedEffect
from tests.calibration.field_mix import draw_campaign

SEED, PLAY = 9002, 3
"""A campaign with backlash of joint 1, whose torque the sensor reads to a quarter of the band."""


@pytest.mark.long
def test_the_band_of_a_play_is_not_broadened_by_the_sensors_noise() -> None:
    """Evaluated at the wrench as read it comes out as 33.8 N·m, and so soft that a knee would fit better."""
    campaign = draw_campaign(SEED, PLAY)
    left = {}
    for name in ("backlash", "two-slope"):
        added = [
            PlacedEffect(one.effect, one.place, {}) for one in campaign.hidden if one.effect.name == "tool-compliance"
        ]
        place = next(one.place for one in campaign.hidden if one.effect.name == "backlash")
        added.append(PlacedEffect(built_in_effects()[name], place, {}))
        robot = replace(campaign.model, placed=(*campaign.model.placed, *added))
        fit = fit_observations(fit_problem(campaign.states, robot), robot, Settings())
        rows = fit.linearised()
        left[name] = float(np.sum(rows.space.rows(rows.residual[None]) ** 2))
        assert fit.last_step is None
        if name == "backlash":
            true = next(one for one in campaign.hidden if one.effect.name == name)
            for symbol in ("width", "band"):
                found = fit.parameter(f"{name}.j1.{symbol}")
                assert found.value is not None
                assert found.std is not None
                assert abs(found.value - true.values[symbol]) < 3.0 * found.std
    assert left["backlash"] < left["two-slope"] - 4.0


def test_a_wrench_that_would_go_to_and_fro_moves_by_half_as_much_each_time() -> None:
    campaign = draw_campaign(SEED, 7)
    data = fit_problem(campaign.states, campaign.model).data
    states, sigma = data.n_states, 1e-5
    fit = fit_observations(fit_problem(campaign.states, campaign.model), campaign.model, Settings())
    assert fit.noise is not None
    noise = replace(fit.noise, translation=sigma, rotation=sigma, force=1.0, moment=0.0)
    whitening = fit.linearised(noise, data=data).space.whitening
    slope = np.zeros((len(data.measured), 6, states))
    slope[0, 0] = sigma
    residual, shares = sigma * np.ones_like(data.measured), []
    for number in range(WHOLE_PASSES + 3):
        found = wrench_correction(data, residual * (-1.0) ** number * 2.0, slope, noise, whitening)
        data = data.corrected(found)
        shares.append(float(found.relaxation.max()))
    assert shares[0] == 1.0
    np.testing.assert_allclose(np.divide(shares[1:], shares[:-1]), 0.5)
    none = np.zeros((6, states))
    assert step_of(WrenchCorrection(none, none, none, np.ones(states))) == 0.0
