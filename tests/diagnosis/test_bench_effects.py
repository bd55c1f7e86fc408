"""A soft fixture on a bench of clamped joints: found first in the whole catalogue, and not where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.diagnosis.scans.candidates import list_candidates
from stiffcal.diagnosis.scans.lack_of_fit import family_p
from stiffcal.diagnosis.scans.load_scan import LoadScan, scan_candidates
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.clamped_bench import clamped_bench
from tests.laboratory.effect_bench import robot_chain
from tests.laboratory.robots import six_axis_joints

CHAIN = robot_chain()


def scan_of(translation: float, rotation: float) -> LoadScan:
    """Return all candidates in addition to compliant drives, on the bench with a fixture."""
    fixture = np.diag([translation] * 3 + [rotation] * 3)
    states = clamped_bench(CHAIN, six_axis_joints(np.random.default_rng(5), 3), (1, 2, 3, 5), fixture)
    drives = tuple(PlacedEffect(JointCompliance(), Place("joints", (k,))) for k in range(1, 7))
    fit = identify_parameters(states, CompliantRobot(CHAIN, drives, deformed=False))
    candidates, not_tried = list_candidates(fit.robot, states, built_in_effects())
    assert "fixture-compliance" not in [effect.effect for effect in not_tried]
    return scan_candidates(fit, candidates)


def test_a_soft_fixture_is_found_first() -> None:
    best = scan_of(4e-8, 4e-7).trials[0]
    assert best.candidate.name == "fixture-compliance setup"
    np.testing.assert_allclose(best.score.solution[-2:], [4e-8, 4e-7], rtol=0.01)


def test_a_rigid_fixture_is_not() -> None:
    scan = scan_of(0.0, 0.0)
    (own,) = [trial for trial in scan.trials if trial.candidate.name == "fixture-compliance setup"]
    assert family_p(scan, own) > 0.01
    assert own.score.heldout.sum() == pytest.approx(scan.base.heldout.sum(), rel=1e-3)
