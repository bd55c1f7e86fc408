"""Which candidate is named: by evidence, not because it is simple; and whether one pose decides."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.diagnosis.candidates import list_candidates
from stiffcal.diagnosis.deletions import rivals_without_a_pose, too_many_alike
from stiffcal.diagnosis.explained import Explained, explained_share
from stiffcal.diagnosis.judge import LackOfFit
from stiffcal.diagnosis.load_scan import scan_candidates
from stiffcal.diagnosis.naming import displacement_cosine, look_alikes, near_best, times_typical
from stiffcal.diagnosis.scan import Scan, Trial
from stiffcal.identification.identify import Settings, fit_observations, fit_problem
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.catalogue import find_effects
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)
RUNS = 8


def with_tilt(joint: int, size: float) -> CompliantRobot:
    """Return the medium robot with one bearing that tilts."""
    robot = medium_robot()
    tilt = PlacedEffect(find_effects()["bearing-tilt"], Place("joints", (joint,)), {"x": size, "y": 0.5 * size})
    return replace(robot, placed=(*robot.placed, tilt))


@cache
def states_of(joint: int, size: float) -> LoadStates:
    return played(with_tilt(joint, size), runs=RUNS, noise=NOISE, load_scatter=0.03, seed=11)


@cache
def scan_of(spoilt: bool) -> Scan:
    """Scan all bearings' tilts where joint 3's is hidden; ``spoilt``: one run is as if joint 5's were, much larger."""
    states = states_of(3, 6e-7)
    if spoilt:
        first, other = states.run == 0, states_of(5, 5e-5)
        position = np.where(first[:, None, None], other.position, states.position)
        rotation = np.where(first[:, None, None, None], other.rotation, states.rotation)
        states = replace(states, position=position, rotation=rotation)
    robot, catalogue = joint_springs(six_axes()), {"bearing-tilt": find_effects()["bearing-tilt"]}
    fit = fit_observations(fit_problem(states, robot), robot, Settings())
    return scan_candidates(fit, list_candidates(robot, states, catalogue)[0])


def trial_of(scan: Scan, name: str) -> Trial:
    return next(trial for trial in scan.trials if trial.candidate.name == name)


def test_the_cosine_of_two_candidates_is_of_what_the_model_cannot_absorb() -> None:
    """Its square is the share of one's squares, beyond the model's own columns, that the other takes away."""
    scan = scan_of(False)
    first, second = (trial_of(scan, f"bearing-tilt j{joint}") for joint in (3, 5))
    columns = []
    for trial in (first, second):
        added = trial.score.solution[-len(trial.regressor.symbols) :]
        columns.append(scan.space.rows(np.einsum("q,qmn->mn", added, trial.regressor.columns)[None])[0])
    own = scan.space.rows(scan.own_columns).T

    def left(known: Floats) -> float:
        return float(np.sum((columns[0] - known @ np.linalg.lstsq(known, columns[0])[0]) ** 2))

    squared = 1.0 - left(np.column_stack([own, columns[1]])) / left(own)
    assert displacement_cosine(scan, first, second) ** 2 == pytest.approx(squared, rel=1e-6)
    assert displacement_cosine(scan, first, first) == pytest.approx(1.0)
    others, cosines = look_alikes(scan, [first, second], first)
    assert others == (second.candidate,)
    assert cosines == (displacement_cosine(scan, second, first),)


def test_no_pose_decides_where_all_agree() -> None:
    scan = scan_of(spoilt=False)
    near = near_best(scan)
    assert near[0].candidate.name == "bearing-tilt j3"
    assert rivals_without_a_pose(scan, near, near[0]) == ()


def test_the_pose_that_decides_is_named_with_the_effects_between_which_it_decides() -> None:
    scan = scan_of(spoilt=True)
    near = near_best(scan)
    assert near[0].candidate.name != "bearing-tilt j3"
    rivals = {rival.candidate.name: rival for rival in rivals_without_a_pose(scan, near, near[0])}
    assert rivals["bearing-tilt j3"].deciding == (0,)
    assert rivals[near[0].candidate.name].deciding == ()
    assert len(rivals) <= 4


def test_sizes_are_held_against_the_catalogues() -> None:
    scan = scan_of(spoilt=False)
    typical = {spec.symbol: spec.typical for spec in find_effects()["bearing-tilt"].parameters}
    assert times_typical(trial_of(scan, "bearing-tilt j3")) == pytest.approx(6e-7 / typical["x"], rel=0.2)


def lack(ratio: float) -> LackOfFit:
    return LackOfFit(ratio**2, (100.0, np.inf), 0.0, ratio)


def scan_with(heldout: list[float]) -> Scan:
    """Return as much of a scan as the share needs: held-out squares of each pose, in units of the noise."""
    squares = np.array(heldout)
    base = SimpleNamespace(heldout=squares)
    return cast("Scan", SimpleNamespace(base=base, dof=10 * len(squares), folds=tuple(range(len(squares)))))


def share_between(before: list[float], after: list[float]) -> Explained:
    ratios = [float(np.sqrt(np.sum(squares) / (10 * len(squares)))) for squares in (before, after)]
    return explained_share(scan_with(before), scan_with(after), lack(ratios[0]), lack(ratios[1]))


def test_the_share_is_of_the_avoidable_error_and_has_an_interval_over_poses() -> None:
    explained = share_between([50.0, 60.0, 40.0, 50.0] * 3, [14.0, 14.0, 14.0, 14.0] * 3)
    assert explained.share == pytest.approx(0.9)
    assert 0.85 < explained.low < 0.9 < explained.high < 0.95
    assert explained.whole


def test_a_share_that_one_pose_makes_is_part_of_the_answer_only() -> None:
    explained = share_between([400.0] + [20.0] * 11, [10.0] + [20.0] * 11)
    assert explained.share > 0.7
    assert explained.low < 0.1
    assert not explained.whole


def test_below_the_noise_the_share_speaks_against_an_effect_only_where_resampling_agrees() -> None:
    assert share_between([14.0, 15.0, 13.0] * 4, [11.0, 11.5, 10.0] * 4).whole
    assert not share_between([14.0, 14.1, 13.9] * 4, [13.0, 13.1, 12.9] * 4).whole


def test_below_the_noise_a_share_that_leaves_more_than_an_adequate_model_is_part_of_the_answer() -> None:
    """Residuals of 1.22 times the noise, of which effects leave 1.06: three quarters, which may be all or not."""
    explained = share_between([13.0, 17.0, 15.0, 15.0, 12.0, 18.0] * 2, [12.8, 9.8, 12.0, 10.4, 12.6, 9.8] * 2)
    assert 0.7 < explained.share < 0.8 < explained.high
    assert not explained.whole
    assert not explained.too_little


def test_of_laws_that_are_one_in_a_limit_the_simpler_is_named() -> None:
    """Two slopes with a knee far below all torques are backlash: the data cannot show which, and backlash is named."""
    robot = medium_robot()
    backlash = PlacedEffect(find_effects()["backlash"], Place("joints", (1,)), {"width": 4e-4, "band": 0.5})
    states = played(replace(robot, placed=(*robot.placed, backlash)), runs=8, noise=NOISE, seed=4)
    catalogue = {name: find_effects()[name] for name in ("backlash", "two-slope")}
    model = joint_springs(six_axes())
    scan = scan_candidates(
        fit_observations(fit_problem(states, model), model, Settings()), list_candidates(model, states, catalogue)[0]
    )
    near = near_best(scan)
    assert near[0].candidate.name == "backlash j1"
    two_slope = trial_of(scan, "two-slope j1")
    # Also where the law with the knee happens to come first, and by whatever pose it does.
    ahead = replace(two_slope, score=replace(two_slope.score, heldout=0.999 * near[0].score.heldout))
    others = tuple(trial for trial in scan.trials if trial.candidate.name != "two-slope j1")
    near = near_best(replace(scan, trials=(ahead, *others)))
    assert [trial.candidate.name for trial in near][:2] == ["backlash j1", "two-slope j1"]
    assert rivals_without_a_pose(scan, near, near[0]) == ()


def test_where_too_many_look_alike_nothing_is_named() -> None:
    scan = scan_of(spoilt=False)
    near = list(scan.trials[:6])
    rivals = too_many_alike(scan, near, near[0])
    assert [rival.candidate.name for rival in rivals] == [trial.candidate.name for trial in near[:4]]
    assert not any(rival.deciding for rival in rivals)
    assert too_many_alike(scan, near[:5], near[0]) == ()
