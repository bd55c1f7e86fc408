"""Large campaigns: the same answers without keeping everything at once, memory in proportion to the states."""

from __future__ import annotations

import tracemalloc
import weakref
from collections.abc import Iterator

import numpy as np
import pytest

import stiffcal.diagnosis.scans.folds
import stiffcal.estimation.triangular
import stiffcal.identification.fitting.regressors
import stiffcal.identification.noise.projection
from stiffcal.diagnosis.remainder.structure import what_it_follows
from stiffcal.diagnosis.scans.base_rows import choice_groups
from stiffcal.diagnosis.scans.candidates import list_candidates
from stiffcal.diagnosis.scans.folds import FoldProducts
from stiffcal.diagnosis.scans.load_scan import LoadScan, scan_candidates
from stiffcal.diagnosis.scans.scoring import score_variants
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.estimation.triangular import triangular_of_rows
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.fitting.regressors import StoredRegressor
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.judgement.document import diagnosis_result
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

NOISE = Sigma(16e-6, 30e-6)
TRIED = ("backlash", "cubic-stiffness", "joint-compliance", "target-offset", "two-slope")


def with_play(runs: int) -> LoadStates:
    """Return states of a robot with springs and a play in joint 4."""
    robot = medium_robot()
    play = find_effects()["backlash"]
    added = PlacedEffect(play, Place("joints", (4,)), {spec.symbol: spec.typical for spec in play.parameters})
    return played(CompliantRobot(robot.chain, (*robot.placed, added)), runs=runs, noise=NOISE)


def scan_of(runs: int) -> tuple[LoadScan, LoadStates]:
    """Return a scan without candidates, of springs alone."""
    states = with_play(runs)
    return scan_candidates(identify_parameters(states, joint_springs(six_axes())), []), states


@pytest.mark.long
def test_a_diagnosis_is_the_same_when_signatures_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """And when rows are whitened, factorised and solved a little at a time, as those of 20 000 states are."""
    states, robot = with_play(5), joint_springs(six_axes())
    catalogue = {name: effect for name, effect in find_effects().items() if name in TRIED}
    whole = diagnose_states(states, robot, catalogue)
    monkeypatch.setattr(stiffcal.identification.fitting.regressors, "MOST_KEPT", 0)
    monkeypatch.setattr(stiffcal.identification.noise.projection, "NUMBERS_AT_ONCE", 3000)
    monkeypatch.setattr(stiffcal.estimation.triangular, "NUMBERS_AT_ONCE", 3000)
    monkeypatch.setattr(stiffcal.diagnosis.scans.folds, "NUMBERS_AT_ONCE", 200)
    pieces = diagnose_states(states, robot, catalogue)
    assert all(isinstance(trial.regressor, StoredRegressor) for trial in pieces.first.trials)
    expected, found = diagnosis_result(whole), diagnosis_result(pieces)
    assert [effect.effect for effect in found.missing] == ["backlash"]
    for mine, other in zip(found.missing, expected.missing, strict=True):
        assert (mine.effect, mine.where, mine.firm) == (other.effect, other.where, other.firm)
        assert mine.probability == pytest.approx(other.probability, abs=1e-6)
    for finding, like in zip(found.findings, expected.findings, strict=True):
        assert (finding.effect, finding.where, finding.verdict) == (like.effect, like.where, like.verdict)
        for key in ("size_m", "p_value", "explains", "probability"):
            assert getattr(finding, key) == pytest.approx(getattr(like, key), rel=1e-6, abs=1e-9)
        after = dict(finding.heldout_rms_after.items())
        assert after == pytest.approx(dict(like.heldout_rms_after.items()), rel=1e-9)


def test_memory_of_the_search_for_structure_grows_with_the_states() -> None:
    """Four times the runs take at most six times the memory; with every run's curves over all states it was sixteen."""
    peaks = []
    for runs in (6, 24):
        scan, states = scan_of(runs)
        what_it_follows(scan, states)  # imports what it needs, which is not to be counted
        tracemalloc.start()
        what_it_follows(scan, states)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 6.0 * peaks[0]


def test_structure_run_by_run_is_that_of_all_runs_together() -> None:
    """The share of the joint angle's family against one least-squares fit with a column for every run and curve."""
    scan, states = scan_of(6)
    data = scan.fit.data
    m, n = data.measured.shape
    load = data.wrench[:3] / np.abs(data.wrench[:3]).max()
    curves = np.zeros((6, 3, m, m, n))
    for run in range(6):
        for k in range(3):
            for row in range(m):
                curves[run, k, row, row] = np.where(data.run == run, load[k], 0.0)
    residual = scan.space.rows(scan.space.centred(scan.residual[None]))[0]
    design = scan.space.rows(curves.reshape(-1, m, n)).T
    left = residual - design @ np.linalg.lstsq(design, residual, rcond=None)[0]
    total, rest = float(residual @ residual), float(left @ left)
    count = design.shape[1]
    by_chance = count * max(1.0, rest / scan.dof)
    avoidable = total - scan.dof if scan.fit.noise is not None else total
    share = (total - rest - by_chance) / avoidable
    found = {one.follows: one.share for one in what_it_follows(scan, states)}
    assert found["joint angle"] == pytest.approx(min(share, 1.0), rel=1e-9)


def test_a_factor_of_many_rows_is_made_piece_by_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the last piece is shorter than the factor."""
    rows = np.random.default_rng(2).normal(size=(5, 83))
    monkeypatch.setattr(stiffcal.estimation.triangular, "NUMBERS_AT_ONCE", 50)
    found = triangular_of_rows(rows)
    assert np.allclose(found.T @ found, rows @ rows.T, rtol=1e-12, atol=1e-12)


def test_what_a_scan_keeps_of_a_candidate_is_bounded_by_the_poses() -> None:
    """Six numbers of eight bytes a pose, and what does not grow; regressors, which have a limit of their own, apart."""
    chain, n = six_axes(), 300
    true = CompliantRobot(chain, tuple(on_all_joints(JointCompliance(), 6, [{"c": 1e-6} for _ in range(6)])))
    states = measured_by(true, absolute_states(chain, n, 1), 2)
    model = CompliantRobot(chain, (*on_all_joints(JointCompliance(), 6), *on_all_joints(LinkGeometry(), 6)))
    fit = identify_parameters(states, model)
    scan = scan_candidates(fit, list_candidates(fit.robot, states, find_effects())[0])
    assert len(scan.trials) > 50
    for trial in scan.trials:
        left, score = trial.score.left, trial.score
        assert left.without is None
        kept = (left.residual, left.rest, score.heldout, score.prediction_change, score.nested, score.normal)
        assert sum(array.nbytes for array in kept) < 64 * n + 50_000


def test_the_rows_of_one_shape_are_kept_at_a_time() -> None:
    rows, folds = np.random.default_rng(3).normal(size=(3, 40)), [slice(start, start + 8) for start in range(0, 40, 8)]

    def shapes() -> Iterator[FoldProducts]:
        for number in range(3):
            shape = FoldProducts.of(rows + number, folds)
            held = weakref.ref(shape)
            yield shape
            del shape
            assert held() is None

    bound = np.full(2, np.inf)
    assert len(score_variants(shapes(), -bound, bound, choice_groups(5)).heldout) == 5
