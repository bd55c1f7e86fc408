"""Hidden effects in campaigns played by the exact balance: named, placed, sized; nothing named where nothing is."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stiffcal.diagnosis.candidates import Candidate
from stiffcal.diagnosis.choosing import choice_without_each_group
from stiffcal.diagnosis.document import diagnosis_result
from stiffcal.diagnosis.heldout_error import left_out_rms, rms_after_choosing
from stiffcal.diagnosis.load_scan import LoadScan
from stiffcal.diagnosis.load_search_context import LoadSearchContext
from stiffcal.diagnosis.pairs import best_pair
from stiffcal.diagnosis.search import one_for_two, search_missing
from stiffcal.diagnosis.search_context import with_trial
from stiffcal.diagnosis.search_results import Search
from stiffcal.documents import document_of
from stiffcal.errors import no_progress
from stiffcal.identification.fit import Fit
from stiffcal.identification.identify import Settings, fit_problem
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mechanics.chain import BeamFrame
from stiffcal.model.catalogue import find_effects
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from stiffcal.model.no_balance import NoBalanceError
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)


def with_hidden(effect: str, place: Place, **values: float) -> CompliantRobot:
    """Return the medium robot with one more effect."""
    robot = medium_robot()
    return replace(robot, placed=(*robot.placed, PlacedEffect(find_effects()[effect], place, values)))


@cache
def searched(name: str) -> tuple[LoadStates, Search]:
    """Play a campaign and search it."""
    hidden = {
        "nothing": medium_robot(),
        "tilt": with_hidden("bearing-tilt", Place("joints", (3,)), x=6e-7, y=3e-7),
        "cubic": with_hidden("cubic-stiffness", Place("joints", (2,)), c2=0.0, c3=4e-13),
    }[name]
    states = played(hidden, runs=8, noise=NOISE, load_scatter=0.03, seed=11)
    return states, search_missing(states, joint_springs(six_axes()), find_effects())


def test_nothing_is_missing_where_nothing_is() -> None:
    """Adequate, nothing supported, nothing unexplained, and the document says so."""
    states, search = searched("nothing")
    assert search.found == ()
    assert not search.unexplained
    diagnosis = diagnosis_result(states, search)
    assert diagnosis.adequate is True
    assert diagnosis.missing == []
    assert not [finding for finding in diagnosis.findings if finding.verdict == "supported"]
    assert diagnosis.summary.startswith("Nothing is missing")


@pytest.mark.parametrize(
    ("name", "effect", "place"),
    [("tilt", "bearing-tilt", "j3"), ("cubic", "cubic-stiffness", "j2")],
)
def test_a_hidden_effect_is_named(name: str, effect: str, place: str) -> None:
    """Named first at its place, or among its look-alikes; the error falls to the noise."""
    states, search = searched(name)
    assert len(search.found) == 1
    found = search.found[0]
    named = [found.candidate.name, *(one.name for one in found.alternatives)]
    assert f"{effect} {place}" in named
    assert search.after is not None
    assert search.after.adequate
    assert search.explained.share > 0.95
    diagnosis = diagnosis_result(states, search)
    json.dumps(document_of(diagnosis), allow_nan=False)
    assert diagnosis.adequate is False
    first = diagnosis.findings[0]
    assert first.verdict == "supported"
    assert "mm" in first.why
    assert (first.heldout_rms_after.translation or 0.0) < (first.heldout_rms_before.translation or 0.0)


def test_one_effect_takes_the_place_of_two() -> None:
    """Tilts at both ends of a link make up for its bending; then the bending alone is named."""
    swing = np.eye(4)
    swing[:3, 3] = six_axes().fixed[2, :3, 3]  # from joint 2 along its frame's x to joint 3
    chain = replace(six_axes(), beams={"swing": BeamFrame(2, swing, float(np.linalg.norm(swing[:3, 3])))})
    truth = with_hidden("link-springs", Place("links", link="swing"), k1=3e6, k2=2.5e6, k3=3e6)
    states = played(replace(truth, chain=chain), runs=8, noise=NOISE, load_scatter=0.03, seed=11)
    model = joint_springs(chain)
    bench = LoadSearchContext(states, fit_problem(states, model), find_effects(), Settings())
    first = scan = bench.look(model)
    chosen = []
    for name in ("bearing-tilt j2", "bearing-tilt j3"):
        trial = next(trial for trial in scan.trials if trial.candidate.name == name)
        chosen.append(trial.candidate)
        scan = bench.look(with_trial(scan.fit.robot, trial))
    simpler = one_for_two(bench, first, scan, chosen, no_progress)
    assert simpler is not None
    assert [one.name for one in simpler[1]] in (["link-springs swing"], ["link-beam swing"])
    assert bench.pace().models == 4
    assert one_for_two(bench, first, simpler[0], simpler[1], no_progress) is None


def test_the_error_of_a_model_alone_is_that_of_its_look_and_costs_no_look() -> None:
    model = joint_springs(six_axes())
    states = played(model, runs=8, noise=NOISE, seed=3)
    bench = LoadSearchContext(states, fit_problem(states, model), find_effects(), Settings())
    scan = bench.look(model)
    trial = next(trial for trial in scan.trials if trial.candidate.name == "bearing-tilt j2")
    alone = bench.error_alone(scan.fit.robot, trial)
    assert bench.pace().models == 1
    assert not alone.trials
    look = bench.look_with(scan.fit.robot, trial)
    assert alone.base.heldout == pytest.approx(look.base.heldout, rel=1e-9)
    assert bench.error_alone(scan.fit.robot, trial) is look


def test_rotation_and_translation_after_choosing_are_measured_each_by_itself() -> None:
    """Where every group of poses chooses the same candidate, the error is that candidate's, not the old one scaled."""
    states, search = searched("tilt")
    scan = search.first
    chosen = choice_without_each_group(scan)
    assert set(chosen) == {1}
    before, after = left_out_rms(scan, None), rms_after_choosing(scan)
    assert after == left_out_rms(scan, scan.trials[0])
    ratios = [(new or 0.0) / (old or 1.0) for new, old in ((after.translation, before.translation),
                                                           (after.rotation, before.rotation))]  # fmt: skip
    assert abs(ratios[0] - ratios[1]) > 0.05, "the test has no power where both fall alike"
    assert diagnosis_result(states, search).heldout_rms_after_choosing == after


def test_the_error_with_a_slip_is_that_of_the_load_cycles_left_out() -> None:
    """No other pose shows a slip: in its own run it is judged cycle by cycle, in the table as in the decision."""
    states = played(medium_robot(), runs=8, noise=NOISE, load_scatter=0.03, seed=11)
    slipped = np.flatnonzero(states.run == 3)
    position = states.position.copy()
    position[slipped[len(slipped) // 2 :]] += np.array([3e-4, 0.0, 1e-4])
    search = search_missing(replace(states, position=position), joint_springs(six_axes()), find_effects())
    finding = diagnosis_result(states, search).findings[0]
    assert finding.effect == "seat-shift"
    before, after = (finding.heldout_rms_before.translation or 0.0), (finding.heldout_rms_after.translation or 0.0)
    assert after < 0.55 * before
    # without that pose nobody would choose a slip in it
    assert finding.heldout_rms_after_choosing is not None
    assert finding.heldout_rms_after_choosing.translation == pytest.approx(before, rel=0.05)


def test_the_hidden_size_comes_back() -> None:
    """The cubic term within four of its standard uncertainties."""
    _, search = searched("cubic")
    one = search.final.parameter("cubic-stiffness.j2.c3")
    assert one.value is not None
    assert one.std is not None
    assert abs(one.value - 4e-13) < 4.0 * one.std


def test_what_is_not_in_the_catalogue_is_unexplained() -> None:
    """A compliance of joint 2 that follows the sine of 2.3 times joint 1's angle has no name here."""
    truth = medium_robot()
    states = played(truth, runs=10, seed=5)
    softer = truth.with_values({"joint-compliance.j2.c": 1.4 / 488310.0})
    wild = played(softer, runs=10, seed=5)
    share = np.sin(2.3 * states.joints[:, 0])
    rng = np.random.default_rng(0)
    position = states.position + share[:, None, None] * (wild.position - states.position)
    rotation = np.where(share[:, None, None, None] > 0.0, wild.rotation, states.rotation)
    position = position + 16e-6 * rng.normal(size=position.shape)
    mixed = replace(states, position=position, rotation=np.full_like(rotation, np.nan))
    search = search_missing(mixed, joint_springs(six_axes()), find_effects())
    assert search.unexplained
    assert search.found == ()
    assert search.could_be == ()
    diagnosis = diagnosis_result(mixed, search)
    assert diagnosis.unexplained is True
    assert any(dependence.follows == "joint angle" for dependence in diagnosis.structure)


def test_a_pair_that_shows_only_together() -> None:
    """Joint 6 turned by joint 3 and, the other way, by joint 2: nearly the same signature, the one hides the other."""
    truth = with_hidden("axis-coupling", Place("pairs", (3, 6)), c=1.1e-5)
    other = PlacedEffect(find_effects()["axis-coupling"], Place("pairs", (2, 6)), {"c": -6.1e-6})
    states = played(replace(truth, placed=(*truth.placed, other)), runs=8, noise=NOISE, load_scatter=0.03, seed=11)
    model = joint_springs(six_axes())
    first = LoadSearchContext(states, fit_problem(states, model), find_effects(), Settings()).look(model)
    pair = best_pair(first)
    assert pair is not None
    assert {one.candidate.name for one in pair} == {"axis-coupling j2-j6", "axis-coupling j3-j6"}
    search = search_missing(states, model, find_effects())
    assert {one.candidate.name for one in search.found} == {"axis-coupling j2-j6", "axis-coupling j3-j6"}
    assert not search.unexplained


def test_a_candidate_without_balance_takes_no_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """Values fitted to a remainder may be so soft that the robot falls: that is no explanation, and no fault."""
    tilting = with_hidden("bearing-tilt", Place("joints", (3,)), x=6e-7, y=3e-7)
    states = played(tilting, runs=8, noise=NOISE, seed=2)
    catalogue = {"bearing-tilt": find_effects()["bearing-tilt"]}
    model = joint_springs(six_axes())
    assert [found.candidate.name for found in search_missing(states, model, catalogue).found] == ["bearing-tilt j3"]
    fit = LoadSearchContext.fit

    def falling(bench: LoadSearchContext, robot: CompliantRobot) -> Fit:
        if any(placed.effect.name == "bearing-tilt" and placed.place.joints == (3,) for placed in robot.placed):
            raise NoBalanceError("the robot finds no balance")
        return fit(bench, robot)

    scanned: list[Fit] = []
    scan = LoadSearchContext.scan

    def counted(
        bench: LoadSearchContext, fit: Fit, candidates: Sequence[Candidate], like: Fit | None = None
    ) -> LoadScan:
        scanned.append(fit)
        return scan(bench, fit, candidates, like)

    monkeypatch.setattr(LoadSearchContext, "fit", falling)
    monkeypatch.setattr(LoadSearchContext, "scan", counted)
    search = search_missing(states, model, catalogue)
    # the present model is not tried anew with one candidate fewer
    assert sum(fit.robot.placed == search.first.fit.robot.placed for fit in scanned) == 1
    assert all(found.candidate.name != "bearing-tilt j3" for found in search.tried)


def test_effects_that_have_no_balance_without_one_of_them_explain_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing shows whether that one is needed."""
    tilts = with_hidden("bearing-tilt", Place("joints", (3,)), x=6e-7, y=3e-7)
    other = PlacedEffect(find_effects()["bearing-tilt"], Place("joints", (5,)), {"x": 1e-6, "y": 1e-6})
    states = played(replace(tilts, placed=(*tilts.placed, other)), runs=8, noise=NOISE, seed=2)
    catalogue = {"bearing-tilt": find_effects()["bearing-tilt"]}
    model = joint_springs(six_axes())
    both = [found.candidate.name for found in search_missing(states, model, catalogue).found]
    assert len(both) == 2
    assert "bearing-tilt j3" in both
    fit = LoadSearchContext.fit

    def falling(bench: LoadSearchContext, robot: CompliantRobot) -> Fit:
        tilting = {placed.place.joints for placed in robot.placed if placed.effect.name == "bearing-tilt"}
        if tilting and (3,) not in tilting:
            raise NoBalanceError("the robot finds no balance")
        return fit(bench, robot)

    monkeypatch.setattr(LoadSearchContext, "fit", falling)
    search = search_missing(states, model, catalogue)
    assert search.tried == ()
    assert search.unexplained
