"""What a model does not need is removed; what held-out poses show is not, however small it is."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from stiffcal.diagnosis.load_search_context import LoadSearchContext
from stiffcal.diagnosis.redundant import redundant_effects
from stiffcal.effects.bearing_tilt import BearingTilt
from stiffcal.effects.cubic_stiffness import CubicStiffness
from stiffcal.identification.identify import Settings, fit_problem, predict_observations
from stiffcal.identification.observation import observe
from stiffcal.model.catalogue import built_in_effects
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Place
from tests.rates.hiding import with_effects
from tests.rates.playing import Hidden, simulate_runs

TILT = PlacedEffect(BearingTilt(), Place("joints", (2,)), {"x": 1e-8, "y": 1e-8})


@pytest.fixture(scope="module")
def campaign() -> Hidden:
    """A campaign with nothing hidden."""
    return simulate_runs("none", np.random.default_rng([14, 0]))


def removed(campaign: Hidden, times_noise: float) -> list[str]:
    """Return what a model with a tilt does not need where the true tilt makes so many times the noise."""
    states, truth = campaign.states, campaign.truth
    data = observe(states, truth.chain)
    bent = predict_observations(with_effects(truth, TILT), data)[:3] - predict_observations(truth, data)[:3]
    bent = bent - np.stack([bent[:, data.run == run].mean(axis=1) for run in data.run], axis=1)
    size = times_noise * campaign.noise[0] / float(np.sqrt(np.mean(bent**2)))
    position = states.position.copy()
    position[data.index, 0] += size * bent.T
    # The places alone: the rotations hold nothing of it, and would speak against it.
    states = replace(states, position=position, rotation=np.full_like(states.rotation, np.nan))
    model = with_effects(campaign.model, PlacedEffect(TILT.effect, TILT.place))
    bench = LoadSearchContext(states, fit_problem(states, model), built_in_effects(), Settings())
    return [candidate.name for candidate in redundant_effects(bench, bench.fit(model), ["joint-compliance"])]


def test_what_is_not_there_is_removed(campaign: Hidden) -> None:
    assert removed(campaign, 0.0) == ["bearing-tilt j2"]


def test_less_than_a_hundredth_of_the_noise_stays_where_the_poses_show_it(campaign: Hidden) -> None:
    assert removed(campaign, 0.13) == []


def test_a_curve_that_holds_the_joint_compliance_is_not_taken_away(campaign: Hidden) -> None:
    curve = PlacedEffect(CubicStiffness().form(("p1", "p2", "p3")), Place("joints", (2,)))
    bench, fit = Mock(), Mock(robot=replace(campaign.model, placed=(curve,)))
    assert redundant_effects(bench, fit, ["joint-compliance"]) == []
    bench.fit.assert_not_called()
