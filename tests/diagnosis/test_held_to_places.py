"""Set-up errors are held against the absolute places of the reference states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.answers.results import AgreementWithPlaces
from stiffcal.diagnosis.held_to_places import ReferencePlaces
from stiffcal.effects.target_offset import TargetOffset
from stiffcal.effects.tracker_frame import TrackerFrame
from stiffcal.effects.wrench_frame import WrenchFrame
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.named_effects import named, named_with_alike
from tests.rates.hiding import with_effects
from tests.rates.playing import Hidden, simulate_runs

SETUP = Place("setup")
# What a turned tracker looks like, and what is nothing like it: trying all takes three times as long.
KNOWN = ("joint-compliance", "bearing-tilt", "base-compliance", "tracker-frame", "target-offset", "wrench-frame")
OFFSET = PlacedEffect(TargetOffset(), SETUP, {"x": 0.01, "y": -0.02, "z": 0.03})
TURN = PlacedEffect(TrackerFrame(), SETUP, {"rx": 0.01, "ry": -0.02, "rz": 0.015})


@pytest.fixture(scope="module")
def campaign() -> Hidden:
    """A campaign whose places show neither."""
    return simulate_runs("none", np.random.default_rng([31, 4]))


@pytest.fixture(scope="module")
def fit(campaign: Hidden) -> Fit:
    return identify_parameters(campaign.states, campaign.model)


def agreement(fit: Fit, states: LoadStates, placed: PlacedEffect, std: float = 0.02) -> AgreementWithPlaces:
    places = ReferencePlaces.of(states, fit)
    assert places is not None
    answer = places.agreement(with_effects(fit.robot, placed), placed, std)
    assert answer is not None
    return answer


def with_target_moved(states: LoadStates, fit: Fit, times: float = 1.0) -> LoadStates:
    """Return the states with the target where `OFFSET` has it."""
    chain = fit.robot.chain
    angles = chain.model_angles(states.joints)
    _, flange = attached_poses(chain, angles, replace(states.setup.targets[0], transform=np.eye(4)))
    shift = np.einsum("nij,j->ni", flange, times * np.array(list(OFFSET.values.values())))
    return replace(states, position=states.position + shift[:, None])


def with_tracker_turned(states: LoadStates, times: float = 1.0) -> LoadStates:
    turn = rotation_from_vector(times * np.array(list(TURN.values.values())))
    return replace(states, position=states.position @ turn.T + [0.1, 0.2, -0.3])


@pytest.mark.parametrize("placed", [OFFSET, TURN])
def test_places_that_do_not_show_it_contradict_it(campaign: Hidden, fit: Fit, placed: PlacedEffect) -> None:
    answer = agreement(fit, campaign.states, placed)
    assert answer.contradicted
    assert not answer.supported
    assert abs(answer.share) < 3.0 * answer.std < 0.3


def test_places_of_a_target_that_is_off_support_it(campaign: Hidden, fit: Fit) -> None:
    answer = agreement(fit, with_target_moved(campaign.states, fit), OFFSET)
    assert answer.supported
    assert answer.share == pytest.approx(1.0, abs=3.0 * answer.std)


def test_places_of_a_turned_tracker_support_it(campaign: Hidden, fit: Fit) -> None:
    answer = agreement(fit, with_tracker_turned(campaign.states), TURN)
    assert answer.supported
    assert answer.share == pytest.approx(1.0, abs=3.0 * answer.std)


def test_a_turned_tracker_is_no_evidence_for_a_target_elsewhere(campaign: Hidden, fit: Fit) -> None:
    assert agreement(fit, with_tracker_turned(campaign.states), OFFSET).contradicted


def test_half_the_value_contradicts_it(campaign: Hidden, fit: Fit) -> None:
    assert agreement(fit, with_tracker_turned(campaign.states, 0.5), TURN).contradicted


def test_a_value_that_is_not_known_is_not_contradicted(campaign: Hidden, fit: Fit) -> None:
    answer = agreement(fit, campaign.states, TURN, std=0.5)
    assert not answer.contradicted
    assert not answer.supported


def test_what_places_cannot_show_is_not_judged(campaign: Hidden, fit: Fit) -> None:
    turned = PlacedEffect(WrenchFrame(), SETUP, {"rx": 0.02})
    places = ReferencePlaces.of(campaign.states, fit)
    assert places is not None
    assert places.agreement(with_effects(fit.robot, turned), turned, 0.02) is None


@pytest.mark.long
def test_places_decide_whether_a_turned_tracker_is_named() -> None:
    hidden = simulate_runs("one 1x", np.random.default_rng([31, 5]), only="tracker-frame")
    (turn,) = hidden.hidden
    catalogue = {name: effect for name, effect in built_in_effects().items() if name in KNOWN}
    found = diagnose_states(hidden.states, hidden.model, catalogue)
    assert named(found) == ["tracker-frame setup"]
    trial = found.trial_of(found.found[0].candidate)
    assert trial is not None
    assert trial.places is not None
    assert trial.places.supported
    back = rotation_from_vector(-np.array([turn.values[axis] for axis in ("rx", "ry", "rz")]))
    first = np.searchsorted(hidden.states.run, hidden.states.run)
    rest = hidden.states.position[first]
    unturned = replace(hidden.states, position=hidden.states.position - rest + rest @ back.T)
    refused = diagnose_states(unturned, hidden.model, catalogue)
    assert not any("tracker-frame setup" in names for names in named_with_alike(refused))
    assert refused.unexplained
