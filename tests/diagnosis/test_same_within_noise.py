"""Candidates that displace the target alike to within the noise are look-alikes, whatever poses left out give.

With one target and no payload the sag by a wrong weight of the swing is a sine of joint 2's angle, but for what the
other joints turn: an eccentric encoder of that joint does the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stiffcal.diagnosis.scans.candidates import list_candidates
from stiffcal.diagnosis.scans.lack_of_fit import _not_reproduced, same_within_noise
from stiffcal.diagnosis.scans.load_scan import LoadScan, scan_candidates
from stiffcal.diagnosis.scans.scan import Trial
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.effects.link_weight import LinkWeight
from stiffcal.effects.seat_shift import SeatShift
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, Place, Values
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.effect_bench import robot_chain
from tests.laboratory.named_effects import named_with_alike

N_POSES = 60
TRUE, ALIKE, OTHER = "joint-eccentricity j2", "link-weight swing", "link-weight link3"
SAG: Values = {"c": 2e-6}


CATALOGUE: dict[str, Effect] = {effect.name: effect for effect in (JointEccentricity(), LinkWeight())}


def places_with(hidden: Sequence[PlacedEffect], seed: int) -> tuple[LoadStates, CompliantRobot]:
    """Return places of a robot with a spring at joint 2 and the hidden effects, and the model without these."""
    chain = robot_chain()
    geometry, joint = tuple(on_all_joints(LinkGeometry(), 6)), Place("joints", (2,))
    true = (*geometry, PlacedEffect(JointCompliance(), joint, SAG), *hidden)
    states = measured_by(CompliantRobot(chain, true), absolute_states(chain, N_POSES, seed), seed)
    return states, CompliantRobot(chain, (*geometry, PlacedEffect(JointCompliance(), joint)))


@cache
def scan_of(seed: int, size: float) -> LoadScan:
    """Scan places with an eccentric joint 2 of so many rad."""
    values = {"a": size, "b": size, "order": 1.0}
    states, robot = places_with([PlacedEffect(JointEccentricity(), Place("joints", (2,)), values)], seed)
    fit = fit_observations(fit_problem(states, robot), robot, Settings())
    return scan_candidates(fit, list_candidates(robot, states, CATALOGUE)[0])


def trial_of(scan: LoadScan, name: str) -> Trial:
    return next(trial for trial in scan.trials if trial.candidate.name == name)


@pytest.mark.parametrize("size", [1e-5, 1e-4, 4e-4])
def test_what_another_candidate_leaves_is_the_misfit_it_would_have_where_the_first_is_true(size: float) -> None:
    """χ² of fits to places made of the first candidate's prediction, without noise."""
    scan = scan_of(0, size)
    for trial, other in ((trial_of(scan, TRUE), trial_of(scan, OTHER)), (trial_of(scan, OTHER), trial_of(scan, TRUE))):
        own, candidate = (
            scan.space.rows(np.concatenate([scan.columns, one.regressor.columns])) for one in (trial, other)
        )
        predicted = trial.score.solution @ own
        misfit = predicted - np.linalg.lstsq(candidate.T, predicted)[0] @ candidate
        left = float(misfit @ misfit)
        assert _not_reproduced(scan, trial, other) == pytest.approx(left, rel=1e-5, abs=1e-6)


def test_what_is_resolved_grows_with_the_size_against_the_noise() -> None:
    """Weight of link 3 and an eccentric joint 2 differ by more than half of their squares."""
    faint, clear = scan_of(0, 1e-5), scan_of(0, 4e-4)
    assert same_within_noise(faint, trial_of(faint, TRUE), trial_of(faint, OTHER))
    assert not same_within_noise(clear, trial_of(clear, TRUE), trial_of(clear, OTHER))
    assert same_within_noise(clear, trial_of(clear, TRUE), trial_of(clear, ALIKE))


def test_a_slip_is_never_the_same() -> None:
    """It is judged inside its run: fits with all poses do not compare it."""
    scan = scan_of(0, 1e-5)
    trial = trial_of(scan, TRUE)
    slip = replace(trial, candidate=replace(trial.candidate, effect=SeatShift()))
    assert not same_within_noise(scan, slip, trial)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("size", [1e-4, 2.5e-4])
def test_the_true_effect_is_listed_with_its_look_alike_and_neither_is_firm(seed: int, size: float) -> None:
    hidden = PlacedEffect(JointEccentricity(), Place("joints", (2,)), {"a": size, "b": size, "order": 1.0})
    found = diagnose_states(*places_with([hidden], seed), CATALOGUE)
    assert named_with_alike(found) == [{TRUE, ALIKE}]
    assert not found.found[0].group.firm


@pytest.mark.practice
def test_of_eccentric_encoders_at_all_joints_no_other_effect_is_named_alone() -> None:
    """0.2 mrad each: a weight that explains one of them as well has it among its look-alikes."""
    rng = np.random.default_rng(22)
    phases, orders = rng.uniform(0.0, 2.0 * np.pi, 6), rng.integers(1, 3, 6)
    orders[1] = 1
    waves = [
        {"a": 2e-4 * float(np.cos(phase)), "b": 2e-4 * float(np.sin(phase)), "order": float(order)}
        for phase, order in zip(phases, orders, strict=True)
    ]
    found = diagnose_states(*places_with(on_all_joints(JointEccentricity(), 6, waves), 22), CATALOGUE)
    listed = named_with_alike(found)
    assert any({TRUE, ALIKE} <= names for names in listed)
    assert all(any(name.startswith("joint-eccentricity") for name in names) for names in listed)
