"""Like effects at neighbouring joints, held together against one law that lies between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stiffcal.diagnosis.document import proposed
from stiffcal.diagnosis.judge import judge_choice
from stiffcal.diagnosis.load_scan import LoadScan
from stiffcal.diagnosis.load_search_context import LoadSearchContext
from stiffcal.diagnosis.scan import Trial
from stiffcal.diagnosis.search import one_for_two
from stiffcal.diagnosis.search_context import NoBalanceWithError, with_trial
from stiffcal.diagnosis.search_results import MissingEffect
from stiffcal.diagnosis.together import as_one, better_set, sets_next_to, with_sets_alike
from stiffcal.diagnosis.words import candidate_in_words
from stiffcal.effects.link_weight import LinkWeight
from stiffcal.errors import no_progress
from stiffcal.identification.identify import Settings, fit_problem
from stiffcal.measurements.load_states import Sigma
from stiffcal.mechanics.chain import BeamFrame, Chain
from stiffcal.model.catalogue import built_in_effects
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from stiffcal.model.no_balance import NoBalanceError
from stiffcal.model.summary import Where
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

TRIED = {name: built_in_effects()[name] for name in ("bearing-tilt", "joint-translation", "link-springs")}
NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)
TILTS = {2: (1e-7, 1e-7), 3: (1e-7, 1e-7)}
"""rad/(N·m) of both directions, at the ends of the swing: a fifth of the arm's own compliance there."""


def with_swing() -> Chain:
    """Return the medium robot with the swing as a link, from joint 2 to joint 3."""
    swing = np.eye(4)
    swing[:3, 3] = six_axes().fixed[2, :3, 3]
    return replace(six_axes(), beams={"swing": BeamFrame(2, swing, float(np.linalg.norm(swing[:3, 3])))})


def tilts(compliances: dict[int, tuple[float, float]]) -> list[PlacedEffect]:
    """Return bearings that tilt, x and y by joint."""
    return [
        PlacedEffect(TRIED["bearing-tilt"], Place("joints", (joint,)), {"x": x, "y": y})
        for joint, (x, y) in compliances.items()
    ]


def springs(stiffness: float) -> list[PlacedEffect]:
    """Return the springs of the swing."""
    values = dict.fromkeys(("k1", "k2", "k3"), stiffness)
    return [PlacedEffect(TRIED["link-springs"], Place("links", link="swing"), values)]


def look_at(hidden: Sequence[PlacedEffect], seed: int) -> tuple[LoadSearchContext, LoadScan]:
    """Return a look at a model of joint springs alone, in a campaign of a robot with hidden effects."""
    robot, chain = medium_robot(), with_swing()
    truth = replace(robot, chain=chain, placed=(*robot.placed, *hidden))
    states, model = played(truth, runs=8, noise=NOISE, load_scatter=0.03, seed=seed), joint_springs(chain)
    bench = LoadSearchContext(states, fit_problem(states, model), TRIED, Settings())
    return bench, bench.look(model)


@cache
def tilted() -> tuple[LoadSearchContext, LoadScan]:
    """Return the look at a robot whose bearings tilt at both ends of the swing, and whose links are rigid."""
    return look_at(tilts(TILTS), 11)


def trial_of(scan: LoadScan, name: str) -> Trial:
    return next(trial for trial in scan.trials if trial.candidate.name == name)


def alone(scan: LoadScan, name: str) -> MissingEffect:
    """Return an effect as if it were named with no other that looks alike."""
    trial = trial_of(scan, name)
    return MissingEffect(trial.candidate, (), judge_choice(scan, trial))


def test_tilts_at_both_ends_of_a_link_are_listed_with_its_springs() -> None:
    """No single tilt comes near the springs that the rigid link does not have; two tilts do, and are the truth."""
    _, scan = tilted()
    named = with_sets_alike(scan, alone(scan, "link-springs swing"))
    assert [other.name for other in named.alternatives] == ["bearing-tilt j2-j3"]
    assert candidate_in_words(named.alternatives[0]) == "bearing-tilt of joints 2 and 3"
    listed = proposed(named).alternatives[0]
    assert (listed.effect, listed.where) == ("bearing-tilt", Where(joints=[2, 3]))
    assert listed.cosine is not None
    assert listed.cosine > 0.9


def test_a_law_with_fewer_parameters_is_no_sum_of_others() -> None:
    _, scan = tilted()
    assert list(sets_next_to(scan, trial_of(scan, "link-springs swing")))
    assert not list(sets_next_to(scan, trial_of(scan, "bearing-tilt j3")))


def test_the_score_of_a_set_is_that_of_its_members_in_one_model() -> None:
    """The linear step with both tilts finds what a refit finds; each is the truth to within four deviations."""
    bench, scan = tilted()
    members = [trial_of(scan, f"bearing-tilt j{joint}") for joint in TILTS]
    both = as_one(scan, members)
    refit = bench.look_with(scan.fit.robot, *members)
    assert float(both.score.heldout.sum()) == pytest.approx(float(refit.base.heldout.sum()), rel=0.02)
    assert both.candidate.n_parameters == 4
    assert both.candidate.place == Place("joints", (2, 3))


def test_what_errs_more_often_than_two_together_does_not_take_their_place() -> None:
    """Springs of the swing err as much as the two tilts, to a hundredth of the noise, and lose nine draws of ten.

    The tilt of joint 1, which would do as well as these two, is left out of the search.
    """
    bench, scan = look_at(tilts(TILTS), 11)
    bench.exclude("bearing-tilt j1")
    assert merged(bench, scan) is None


def test_what_errs_less_often_takes_their_place() -> None:
    """The same two tilts make up for springs that are there."""
    bench, scan = look_at(springs(3e6), 12)
    assert merged(bench, scan) == ["link-springs swing"]


def merged(bench: LoadSearchContext, first: LoadScan) -> list[str] | None:
    """Return what takes the place of tilts of joints 2 and 3 that were added one after the other; None for nothing."""
    scan, chosen = first, []
    for joint in TILTS:
        trial = trial_of(scan, f"bearing-tilt j{joint}")
        chosen.append(trial.candidate)
        scan = bench.look(with_trial(scan.fit.robot, trial))
    simpler = one_for_two(bench, first, scan, chosen, no_progress)
    return None if simpler is None else [candidate.name for candidate in simpler[1]]


def test_a_set_that_errs_clearly_less_takes_the_place_of_one() -> None:
    """Tilts across the swing at one end and along it at the other are no springs at its middle."""
    _, scan = look_at(tilts({2: (0.0, 1.5e-6), 3: (1.5e-6, 0.0)}), 11)
    named = trial_of(scan, "link-springs swing").candidate
    assert {trial.candidate.name for trial in better_set(scan, named)} == {"bearing-tilt j2", "bearing-tilt j3"}


def test_one_joint_of_a_law_that_acts_at_all_is_not_named_alone() -> None:
    """Bearings that tilt at all joints: the best single one is listed with all together; a single true one is not."""
    _, scan = look_at(tilts(dict.fromkeys(range(1, 7), (3e-7, 3e-7))), 11)
    named = with_sets_alike(scan, alone(scan, "bearing-tilt j3"))
    assert [other.name for other in named.alternatives] == ["bearing-tilt j1-j2-j3-j4-j5-j6"]
    _, scan = look_at(tilts({3: (6e-7, 3e-7)}), 11)
    single = alone(scan, "bearing-tilt j3")
    assert with_sets_alike(scan, single) is single


@pytest.mark.parametrize(("moment", "blamed"), [(0.5, "bearing-tilt j3"), (5.0, "link-weight swing")])
def test_an_equilibrium_is_lost_by_a_robot_that_cannot_be(
    moment: float, blamed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is added to a link with its centre outside the robot is not left out of the search in its place."""
    bench, scan = tilted()
    weight = LinkWeight()
    weight.largest = 1.0
    placed = PlacedEffect(weight, Place("links", link="swing"), {"mx": 0.0, "my": moment})
    robot = replace(scan.fit.robot, placed=(*scan.fit.robot.placed, placed))

    def falls(bench: LoadSearchContext, robot: CompliantRobot) -> LoadScan:
        raise NoBalanceError("it falls")

    monkeypatch.setattr(LoadSearchContext, "look", falls)
    with pytest.raises(NoBalanceWithError) as caught:
        bench.look_with(robot, trial_of(scan, "bearing-tilt j3"))
    assert caught.value.name == blamed
