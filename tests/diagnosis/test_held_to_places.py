"""Set-up errors are held against the absolute places of the reference states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.held_to_places import held_to_places
from stiffcal.effects.target_offset import TargetOffset
from stiffcal.effects.tracker_frame import TrackerFrame
from stiffcal.effects.wrench_frame import WrenchFrame
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Place
from tests.rates.hiding import with_effects
from tests.rates.playing import Hidden, simulate_runs

SETUP = Place("setup")
OFFSET = PlacedEffect(TargetOffset(), SETUP, {"x": 0.01, "y": -0.02, "z": 0.03})
TURN = PlacedEffect(TrackerFrame(), SETUP, {"rx": 0.01, "ry": -0.02, "rz": 0.015})


@pytest.fixture(scope="module")
def campaign() -> Hidden:
    """A campaign whose places show neither."""
    return simulate_runs("none", np.random.default_rng([31, 4]))


@pytest.mark.parametrize("placed", [OFFSET, TURN])
def test_places_that_do_not_show_it_contradict_it(campaign: Hidden, placed: PlacedEffect) -> None:
    places = held_to_places(campaign.states, with_effects(campaign.truth, placed), placed)
    assert places is not None
    assert places.contradicted
    assert places.without < 2e-3 < 1e-2 < places.misfit


def test_places_of_a_target_that_is_off_agree(campaign: Hidden) -> None:
    states, chain = campaign.states, campaign.truth.chain
    angles = chain.model_angles(states.joints)
    _, flange = attached_poses(chain, angles, replace(states.setup.targets[0], transform=np.eye(4)))
    moved = states.position + np.einsum("nij,j->ni", flange, list(OFFSET.values.values()))[:, None]
    places = held_to_places(replace(states, position=moved), with_effects(campaign.truth, OFFSET), OFFSET)
    assert places is not None
    assert not places.contradicted
    assert places.misfit < 0.2 * places.without


def test_places_of_a_turned_tracker_agree(campaign: Hidden) -> None:
    turn = rotation_from_vector(np.array(list(TURN.values.values())))
    states = replace(campaign.states, position=campaign.states.position @ turn.T + [0.1, 0.2, -0.3])
    places = held_to_places(states, with_effects(campaign.truth, TURN), TURN)
    assert places is not None
    assert not places.contradicted
    assert places.misfit < 0.2 * places.without


def test_what_places_cannot_show_is_not_judged(campaign: Hidden) -> None:
    turned = PlacedEffect(WrenchFrame(), SETUP, {"rx": 0.02})
    assert held_to_places(campaign.states, with_effects(campaign.truth, turned), turned) is None
