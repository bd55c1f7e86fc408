"""A run or row that disagrees with all the others is found, and what is wrong with it is named."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from stiffcal.diagnosis.suspects import find, selection
from stiffcal.diagnosis.suspects.find import Suspicion, find_misplaced, find_suspects
from stiffcal.diagnosis.suspects.words import suspects_of
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, identify_parameters, predict_observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.runs.time_order import TimeOrder
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.rates import faults
from tests.rates.faults import Faulty, draw_faulty
from tests.rates.hiding import with_effects

LBF = 4.4482216152605


@cache
def sound(form: str) -> Faulty:
    """A table of 24 poses with two loads each, nothing wrong in it."""
    return draw_faulty(np.random.default_rng([20261122, len(form)]), form, "")


def found_in(form: str, states: LoadStates) -> Suspicion:
    return find_suspects(states, sound(form).model)


def own(states: LoadStates, run: int) -> np.ndarray:
    return np.flatnonzero(states.run == run)


def with_wrench(states: LoadStates, run: int, factors: list[float]) -> LoadStates:
    wrench = states.wrench.copy()
    wrench[own(states, run)] *= factors
    return replace(states, wrench=wrench)


def moved(states: LoadStates, picked: np.ndarray, step: float) -> LoadStates:
    position, deflection = states.position.copy(), states.deflection.copy()
    position[picked, 0, :3] += step
    deflection[picked, 0, :3] += step
    return replace(states, position=position, deflection=deflection)


@pytest.mark.parametrize("form", ["rows", "pairs"])
def test_in_a_sound_campaign_nothing_is_suspect(form: str) -> None:
    suspicion = found_in(form, sound(form).states)
    assert suspicion.not_checked is None
    assert not suspicion.suspects


@pytest.mark.parametrize(("run", "undetermined"), [(3, False), (20, False), (20, True)])
def test_of_many_runs_some_are_fitted_as_long_as_they_determine_all(
    run: int, undetermined: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    fitted: list[int] = []

    def fit(chosen: LoadStates, *others: Any) -> Fit:
        fitted.append(np.unique(chosen.run).size)
        found = identify_parameters(chosen, *others)
        return replace(found, left_at_neutral=frozenset({"x"})) if undetermined and len(fitted) == 1 else found

    faulty = with_wrench(sound("pairs").states, run, [1 / LBF] * 3 + [1.0] * 3)
    whole = found_in("pairs", faulty).suspects[0]
    monkeypatch.setattr(find, "starting_runs", lambda run, _: run < 12)
    monkeypatch.setattr(find, "identify_parameters", fit)
    (suspect,) = found_in("pairs", faulty).suspects
    assert fitted == [12 - (run < 12), *([23] if undetermined else []), 23]  # the last for the answer
    assert (suspect.run, suspect.kind) == (run, "unit")
    assert suspect.score == pytest.approx(whole.score, rel=0.05)


def test_a_run_that_only_the_whole_judgement_doubts_has_a_reason() -> None:
    """A line ended after its colon."""
    states = sound("rows").states
    suspicion = replace(
        found_in("rows", with_wrench(states, 7, [3.0] * 6)), suspects=(find._unknown(4),), without_each=(None,)
    )
    (suspect,) = suspects_of(suspicion, states, sound("rows").model.chain)
    assert (suspect.run, suspect.kind) == ("run05", "unknown")
    assert suspect.why


@pytest.mark.parametrize("form", ["rows", "pairs"])
def test_forces_in_lbf_are_named_with_the_factor(form: str) -> None:
    states = sound(form).states
    suspicion = found_in(form, with_wrench(states, 7, [1 / LBF] * 3 + [1.0] * 3))
    (suspect,) = suspects_of(suspicion, states, sound(form).model.chain)
    assert (suspect.run, suspect.kind) == ("run08", "unit")
    assert suspect.factor == pytest.approx(LBF)
    assert "lbf: multiply by 4.4482" in suspect.likely


@pytest.mark.parametrize("form", ["rows", "pairs"])
def test_a_load_of_the_wrong_sign_is_named_and_that_its_work_is_negative(form: str) -> None:
    states = sound(form).states
    faulty = with_wrench(states, 4, [-1.0] * 6)
    (suspect,) = suspects_of(found_in(form, faulty), faulty, sound(form).model.chain)
    assert (suspect.run, suspect.kind, suspect.factor) == ("run05", "sign", -1.0)
    assert "have opposite directions" in suspect.why


@pytest.mark.parametrize("form", ["rows", "pairs"])
def test_two_runs_with_each_others_angles_are_both_named_mislabelled(form: str) -> None:
    states = sound(form).states
    one, other = (own(states, run) for run in (2, 11))
    joints = states.joints.copy()
    joints[one], joints[other] = states.joints[other], states.joints[one]
    faulty = replace(states, joints=joints)
    suspects = suspects_of(found_in(form, faulty), faulty, sound(form).model.chain)
    assert {(suspect.run, suspect.kind) for suspect in suspects} == {("run03", "mislabelled"), ("run12", "mislabelled")}
    likely = next(suspect.likely for suspect in suspects if suspect.run == "run03")
    # of the tables with a row for each load two rows have the angles of the pose
    assert 'those of run "run12"' in likely or 'those of run "run11"' in likely


def test_angles_that_are_a_copy_of_another_poses_are_named() -> None:
    states = sound("pairs").states
    joints = states.joints.copy()
    joints[own(states, 5)] = states.joints[own(states, 9)]
    faulty = replace(states, joints=joints)
    (suspect,) = suspects_of(found_in("pairs", faulty), faulty, sound("pairs").model.chain)
    assert (suspect.run, suspect.kind) == ("run06", "mislabelled")
    assert 'its joint angles are those of run "run10"' in suspect.likely
    assert "from where the joint angles put it" in suspect.why
    misplaced = find_misplaced(faulty, sound("pairs").model, Settings())
    assert [(one.run, one.kind, one.copied) for one in misplaced.suspects] == [(5, "mislabelled", 9)]


def test_a_place_alone_decides_nothing_about_displacements() -> None:
    faulty = with_wrench(sound("pairs").states, 5, [1 / LBF] * 3 + [1.0] * 3)
    assert found_in("pairs", faulty).suspects
    assert find_misplaced(faulty, sound("pairs").model, Settings()).suspects == ()


@pytest.mark.parametrize(("form", "n_runs"), [("rows", 24), ("pairs", 24), ("pairs", 6)])
def test_two_runs_whose_force_logs_are_exchanged_are_both_named(form: str, n_runs: int) -> None:
    """Of six runs only one may be faulty, but for two that are exchanged."""
    states = sound(form).states
    states = states.select(states.run < n_runs)
    second = min(11, n_runs - 1)
    one, other = (own(states, run) for run in (2, second))
    wrench = states.wrench.copy()
    wrench[one], wrench[other] = states.wrench[other], states.wrench[one]
    suspects = found_in(form, replace(states, wrench=wrench)).suspects
    assert {(suspect.run, suspect.kind) for suspect in suspects} == {(2, "exchanged"), (second, "exchanged")}


@pytest.mark.parametrize("form", ["rows", "pairs"])
def test_a_bumped_reading_is_named_with_its_row_and_size(form: str) -> None:
    states = sound(form).states
    row = own(states, 6)[-1]
    faulty = moved(states, np.array([row]), 5e-4)
    (suspect,) = suspects_of(found_in(form, faulty), faulty, sound(form).model.chain)
    assert (suspect.run, suspect.kind, suspect.row) == ("run07", "bump", int(states.row[row]))
    assert "0.8" in suspect.likely  # 0.5 mm along each axis


def test_two_bumped_rows_do_not_hide_each_other() -> None:
    states = sound("rows").states
    faulty = moved(moved(states, own(states, 6), 5e-4), own(states, 7), 5e-4)
    assert {suspect.run for suspect in found_in("rows", faulty).suspects} == {6, 7}


def test_a_step_inside_a_run_stays_with_the_effects() -> None:
    states = draw_faulty(np.random.default_rng(5), "cycles", "").states
    model = draw_faulty(np.random.default_rng(5), "cycles", "").model
    run = own(states, 3)
    suspicion = find_suspects(moved(states, run[len(run) // 2 :], 1e-3), model)
    (suspect,) = suspicion.suspects
    assert suspect.run == 3
    assert suspect.kind == "bump"
    assert suspect.offset is not None
    assert suspect.offset.step
    assert suspect.state == run[len(run) // 2]


def test_the_fit_without_the_suspect_is_that_of_the_sound_campaign() -> None:
    form = "rows"
    states = sound(form).states
    faulty = with_wrench(states, 7, [1 / LBF] * 3 + [1.0] * 3)
    (suspect,) = suspects_of(found_in(form, faulty), faulty, sound(form).model.chain)
    rows = np.flatnonzero(states.run != 7)
    fit = identify_parameters(states.select(rows), sound(form).model)
    assert suspect.without is not None
    for parameter in suspect.without.parameters:
        assert parameter.value == pytest.approx(fit.parameter(parameter.name).value, rel=1e-9)


def test_an_effect_that_shows_in_few_poses_is_no_fault_of_their_runs() -> None:
    """A drive that gives more under one sign of torque, which four rows have: without the catalogue they are bumps.

    Twenty times the noise in the least of the four, and nothing in all others: springs alone and loads of the other
    sign give the opposite displacement, so that a sound table stays one with the signs of some rows turned.
    """
    noise, n_few = 20.0, 4
    states, model = sound("rows").states, sound("rows").model
    springs = identify_parameters(states, model).robot
    asymmetric = built_in_effects()["asymmetric-stiffness"]

    def change(states: LoadStates, c: float) -> np.ndarray:
        data = observe(states, springs.chain)
        robot = with_effects(springs, PlacedEffect(asymmetric, Place("joints", (1,)), {"c": c}))  # no weight on joint 1
        return predict_observations(robot, data) - predict_observations(springs, data)

    def turned(sign: np.ndarray) -> LoadStates:
        wrench, deflection = states.wrench * sign[:, None], states.deflection * sign[:, None, None]
        return replace(states, wrench=wrench, deflection=deflection)

    typical = asymmetric.spec("c").typical
    one, other = (np.linalg.norm(change(turned(sign * np.ones(len(states))), typical), axis=0) for sign in (1.0, -1.0))
    few = np.argsort(np.maximum(one, other))[-n_few:]
    shows = np.where(one > other, 1.0, -1.0)
    campaign = turned(np.where(np.isin(np.arange(len(states)), few), shows, -shows))
    sigma = np.sqrt(3.0) * (states.setup.sigma.translation or np.nan)
    deflection = campaign.deflection.copy()
    deflection[:, 0, :3] += change(campaign, typical * noise * sigma / np.maximum(one, other)[few].min()).T
    campaign = replace(campaign, deflection=deflection)
    assert not find_suspects(campaign, model).suspects
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(find, "explaining_effect", lambda *_: None)
        assert {suspect.run for suspect in find_suspects(campaign, model).suspects} == set(states.run[few])


def test_runs_next_to_each_other_in_time_are_mixed_up_first() -> None:
    states = sound("pairs").states
    order = np.argsort(np.random.default_rng(3).permutation(24))
    time = np.asarray(100.0 * order[states.run] + np.arange(len(states)) % 3, dtype=np.float64)
    ranked = TimeOrder.of(replace(states, time=time), states.members())
    assert np.array_equal(ranked.rank, order)
    near = int(np.flatnonzero(np.abs(order - order[0]) == 1)[0])
    far = int(np.flatnonzero(np.abs(order - order[0]) > 1)[0])
    assert ranked.mix_up_penalty(0, near, 23, 3) < ranked.mix_up_penalty(0, far, 23, 3)
    # where every run's clock starts at zero, the order of the campaign counts
    restarting = TimeOrder.of(replace(states, time=(np.arange(len(states)) % 3).astype(float)), states.members())
    assert np.array_equal(restarting.rank, np.arange(24))


def test_a_run_measured_elsewhere_in_time_is_described_so() -> None:
    states = sound("pairs").states
    rank = np.arange(24)
    rank[[2, 11]] = 11, 2
    time = np.asarray(100.0 * rank[states.run] + np.arange(len(states)) % 3, dtype=np.float64)
    wrench = states.wrench.copy()
    one, other = (own(states, run) for run in (2, 11))
    wrench[one], wrench[other] = states.wrench[other], states.wrench[one]
    faulty = replace(states, wrench=wrench, time=time)
    suspects = {one.run: one for one in suspects_of(found_in("pairs", faulty), faulty, sound("pairs").model.chain)}
    assert 'between those of runs "run11" and "run13", not in the order' in suspects["run03"].why


def test_of_three_runs_none_is_judged_and_the_answer_gives_the_reason() -> None:
    states = sound("pairs").states
    few = states.select(np.flatnonzero(states.run < 3))
    not_checked = found_in("pairs", few).not_checked
    assert not_checked is not None
    assert not_checked.code == "few-runs"
    assert "there are 3 load runs" in not_checked.sentence


def test_among_five_runs_a_wrong_unit_is_named_and_a_bump_is_not() -> None:
    states = sound("pairs").states
    few = states.select(np.flatnonzero(states.run < 5))
    suspicion = found_in("pairs", with_wrench(few, 2, [1 / LBF] * 3 + [1.0] * 3))
    assert [(suspect.run, suspect.kind) for suspect in suspicion.suspects] == [(2, "unit")]
    bumped = found_in("pairs", moved(few, own(few, 2)[-1:], 5e-4))
    assert not bumped.suspects
    assert bumped.not_checked is not None
    assert bumped.not_checked.code == "unit-and-sign-only"


def many(form: str, poses: int, loads: int) -> Faulty:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(faults, "POSES", poses)
        patch.setattr(faults, "LOADS", loads)
        return draw_faulty(np.random.default_rng([7, poses, loads]), form, "sign")


def test_one_of_two_thousand_runs_is_found() -> None:
    campaign = many("rows", 1000, 2)
    suspicion = find_suspects(campaign.states, campaign.model)
    assert [(suspect.run, suspect.kind) for suspect in suspicion.suspects] == [(campaign.runs[0], "sign")]
    assert suspicion.not_checked is None


def test_of_very_long_runs_some_states_are_compared_and_the_answer_gives_their_number(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(selection, "MOST_STATES", 600)
    campaign = many("pairs", 24, 100)
    suspicion = find_suspects(campaign.states, campaign.model)
    assert [(suspect.run, suspect.kind) for suspect in suspicion.suspects] == [(campaign.runs[0], "sign")]
    assert suspicion.not_checked is not None
    assert suspicion.not_checked.code == "some-states"
    assert "600 of 2424 states" in suspicion.not_checked.sentence
    assert suspicion.fit is not None
    assert len(suspicion.fit.data.run) == 23 * 101  # the fit without the suspect is of all the others' states


def test_fits_of_other_experiments_runs_are_not_looked_at() -> None:
    states = sound("pairs").states
    bumped = moved(states, own(states, 6)[-1:], 5e-4)
    runs = tuple(replace(run, compensated=number == 6) for number, run in enumerate(bumped.runs))
    assert not found_in("pairs", replace(bumped, runs=runs)).suspects
