"""What a model does not need is superfluous; what its poses show is not, however small it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.bearing_tilt import BearingTilt
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.rates.hiding import with_effects
from tests.rates.playing import Hidden, simulate_runs

pytestmark = pytest.mark.long

TILT = PlacedEffect(BearingTilt(), Place("joints", (2,)), {"x": 1e-8, "y": 1e-8})
KNOWN = {name: built_in_effects()[name] for name in ("bearing-tilt", "joint-compliance")}


@pytest.fixture(scope="module")
def campaign() -> Hidden:
    """A campaign with nothing hidden."""
    return simulate_runs("none", np.random.default_rng([14, 0]))


def diagnosed(campaign: Hidden, times_noise: float) -> DiagnosedStates:
    """Diagnose a model with a tilt where the true tilt makes so many times the noise."""
    states, truth = campaign.states, campaign.truth
    data = observe(states, truth.chain)
    bent = predict_observations(with_effects(truth, TILT), data)[:3] - predict_observations(truth, data)[:3]
    bent = bent - np.stack([bent[:, data.run == run].mean(axis=1) for run in data.run], axis=1)
    size = times_noise * campaign.noise[0] / float(np.sqrt(np.mean(bent**2)))
    position = states.position.copy()
    position[data.index, 0] += size * bent.T
    # The places alone: the rotations hold nothing of it, and would speak against it.
    states = replace(states, position=position, rotation=np.full_like(states.rotation, np.nan))
    return diagnose_states(states, with_effects(campaign.model, PlacedEffect(TILT.effect, TILT.place)), KNOWN)


def superfluous(found: DiagnosedStates) -> list[str]:
    return [f"{placed.effect.name} {placed.place.label}" for placed in found.superfluous]


def test_what_is_not_there_is_superfluous(campaign: Hidden) -> None:
    found = diagnosed(campaign, 0.0)
    assert superfluous(found) == ["bearing-tilt j2"]
    assert found.held == ()


@pytest.mark.parametrize("times_noise", [0.5, 0.25])
def test_what_the_poses_show_is_needed(campaign: Hidden, times_noise: float) -> None:
    found = diagnosed(campaign, times_noise)
    assert superfluous(found) == []
    assert [one.candidate.name for one in found.held] == ["bearing-tilt j2"]
    assert found.adequate
