"""MuJoCo moves the hidden robots as the balance does: two codes, one physics, far below the instruments' noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.practice_marks import with_practice
from tests.rates.faults import draw_faulty
from tests.rates.hiding import INSIDE
from tests.rates.measuring import move
from tests.rates.mujoco_player import laws_of, move_by_mujoco
from tests.rates.playing import CLASSES, Hidden, player_of, simulate_runs

# Share of the tracker's noise: products of two small turns, which the two codes order differently, are below it.
MOST_APART = 0.02
# A law in a joint, one between joints, a beam, an instrument, and what the catalogue does not know.
HERE = ("friction-hysteresis", "axis-coupling", "link-beam", "wrench-frame", "torque-product")
OUTSIDE = ("cross-stiffness", "torque-product", "quadratic-cross", "loose-beyond", "wander")


def plan_of(campaign: Hidden) -> LoadStates:
    """Return the campaign's loads: every run begins unloaded, no motor is pushed off, no reading is set aside."""
    states = campaign.states
    first = np.searchsorted(states.run, states.run)
    used = np.full(len(states), "", dtype=np.str_)
    wrench = np.where(states.reference[:, None], 0.0, states.wrench)
    return replace(states, wrench=wrench, joints=states.joints[first], set_aside=used, set_aside_code=used)


def difference(campaign: Hidden) -> float:
    """Return the rms difference between MuJoCo's and the balance's displacements, over the noise."""
    plan = plan_of(campaign)
    kept = tuple(one for one in campaign.truth.placed if one.effect.name == "joint-compliance")
    springs = CompliantRobot(campaign.truth.chain, kept)
    ours, theirs = (move(player, plan, springs, campaign.truth).moved for player in ("balance", "mujoco"))
    noise = np.repeat(campaign.noise, 3)[: ours.shape[1]]
    return float(np.sqrt(np.mean(((theirs[:, : ours.shape[1]] - ours) / noise) ** 2)))


@pytest.mark.parametrize("name", with_practice([*INSIDE, "wrench-origin"], *HERE))
def test_effects_of_the_catalogue(name: str) -> None:
    campaign = simulate_runs("one 1x", np.random.default_rng([5, 1]), name)
    assert [one.effect.name for one in campaign.hidden] == [name]
    assert difference(campaign) < MOST_APART


@pytest.mark.parametrize("name", with_practice(OUTSIDE, *HERE))
def test_effects_outside_the_catalogue(name: str) -> None:
    draws = (simulate_runs("outside 1x", np.random.default_rng([6, number])) for number in range(100))
    campaign = next(drawn for drawn in draws if drawn.hidden[0].effect.name == name)
    assert difference(replace(campaign, truth=off_the_edge(campaign.truth))) < MOST_APART


def off_the_edge(robot: CompliantRobot) -> CompliantRobot:
    """Return the robot with no pose's angle at the very angle where a law jumps: there rounding decides."""
    placed = tuple(
        replace(one, values={**one.values, "angle": one.values["angle"] + 1e-6}) if "angle" in one.values else one
        for one in robot.placed
    )
    return replace(robot, placed=placed)


def test_without_the_law_they_differ_by_the_effect() -> None:
    """What is compared shows: MuJoCo without the hidden effect is a whole noise away."""
    campaign = simulate_runs("one 4x", np.random.default_rng([5, 1]), "backlash")
    assert laws_of(campaign.truth.chain, campaign.hidden[0])
    plan = plan_of(campaign)
    kept = tuple(one for one in campaign.truth.placed if one not in campaign.hidden)
    springs = CompliantRobot(campaign.truth.chain, kept)
    ours = move("balance", plan, springs, campaign.truth).moved
    theirs = move("mujoco", plan, springs, springs).moved[:, : ours.shape[1]]
    assert np.sqrt(np.mean(((theirs - ours)[:, :3] / campaign.noise[0]) ** 2)) > 1.0


@pytest.mark.parametrize("form", ["rows", "pairs"])
def test_rows_and_pairs(form: str) -> None:
    campaign = draw_faulty(np.random.default_rng(3), form, "", player="mujoco")
    other = draw_faulty(np.random.default_rng(3), form, "")
    if form == "rows":
        np.testing.assert_allclose(campaign.states.deflection, other.states.deflection, rtol=0.0, atol=1e-7)
    else:
        np.testing.assert_allclose(campaign.states.position, other.states.position, rtol=0.0, atol=1e-7)


def test_every_third_campaign_of_the_new_classes_is_mujocos() -> None:
    assert [player_of("mixed", "no repeats", number) for number in range(4)] == [
        "mujoco", "balance", "balance", "mujoco",
    ]  # fmt: skip
    assert {player_of("mixed", kind, 0) for kind in CLASSES[:9]} == {"balance"}
    assert player_of("mujoco", "none", 1) == "mujoco"


def test_a_campaign_that_mujoco_plays() -> None:
    drawn = simulate_runs("noise half", np.random.default_rng([11, 1]), player="mujoco")
    assert drawn.player == "mujoco"
    assert np.isfinite(drawn.states.position).all()


def test_an_effect_that_mujoco_does_not_model() -> None:
    campaign = simulate_runs("none", np.random.default_rng([5, 1]))
    drift = PlacedEffect(built_in_effects()["encoder-drift"], Place("joints", (1,)), {"rad_per_s": 1e-6})
    robot = CompliantRobot(campaign.truth.chain, (*campaign.truth.placed, drift))
    with pytest.raises(ValueError, match="encoder-drift"):
        move_by_mujoco(plan_of(campaign), robot)
