"""friction-hysteresis: the play operator, by hand, by a plain loop, and as a closed loop of known area."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats, Integers
from stiffcal.compensation.fitted_robot import _left_out
from stiffcal.effects.friction_hysteresis import FrictionHysteresis
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import RZ, Law, NodeLoads, Place, joint_node
from stiffcal.model.forms import form_of
from stiffcal.model.laws.memory import play_operator
from tests.laboratory.effect_bench import bare_states, displacement, loads, order_of, robot_chain

EFFECT = FrictionHysteresis()
PLACE = Place("joints", (2,))
NODE = joint_node(2)


def followed(torque: Floats, slip: float, weight: float = 0.0, run: list[int] | None = None) -> Floats:
    """Return P_r[τ] as the effect makes it."""
    carried = loads({(NODE, RZ): torque}, order_of(run or [0] * len(torque)), {(NODE, RZ): weight})
    return np.asarray(displacement(EFFECT, PLACE, {"c": 1.0, "slip": slip}, carried)[NODE, RZ])


def test_by_hand() -> None:
    """Slip 10: nothing to 10, then 10 behind; on the way back flat over 20, then 10 behind from the other side."""
    torque = np.array([0.0, 5.0, 10.0, 30.0, 50.0, 40.0, 30.0, 0.0, -50.0, -30.0, 0.0])
    np.testing.assert_allclose(
        followed(torque, 10.0), [0.0, 0.0, 0.0, 20.0, 40.0, 40.0, 40.0, 10.0, -40.0, -40.0, -10.0]
    )


def plain(torque: Floats, slip: float, run: Integers, weight: Floats) -> Floats:
    """The definition, one state after another."""
    result: Floats = np.zeros_like(torque)
    value = 0.0
    for i in range(len(torque)):
        if i == 0 or run[i] != run[i - 1]:
            value = min(max(0.0, weight[i] - slip), weight[i] + slip)
        value = result[i] = min(max(value, torque[i] - slip), torque[i] + slip)
    return result


@pytest.mark.parametrize("slip", [0.0, 0.3, 2.0, 50.0])
def test_scan_equals_the_plain_loop(slip: float) -> None:
    rng = np.random.default_rng(8)
    run = np.sort(rng.integers(0, 9, 300))
    torque, weight = rng.normal(0.0, 3.0, 300), rng.normal(0.0, 5.0, 9)[run]
    np.testing.assert_allclose(play_operator(torque, slip, run, weight), plain(torque, slip, run, weight), atol=1e-13)


def test_memory_begins_anew_with_each_run() -> None:
    torque = np.array([0.0, 50.0, 0.0, 0.0, 50.0, 0.0])
    once, twice = followed(torque[:3], 10.0), followed(torque, 10.0, run=[0, 0, 0, 1, 1, 1])
    np.testing.assert_allclose(twice, [*once, *once])


def test_weight_acts_before_the_first_state() -> None:
    """With 100 N·m of weight the part has followed to 90 before any load; a small load then moves nothing."""
    np.testing.assert_allclose(
        followed(np.array([100.0, 105.0, 120.0, 100.0]), 10.0, 100.0), [90.0, 95.0, 110.0, 110.0]
    )
    np.testing.assert_allclose(followed(np.array([100.0, 95.0, 79.0]), 10.0, 100.0), [90.0, 90.0, 89.0])


def test_weight_only_state_has_no_memory() -> None:
    moved = displacement(EFFECT, PLACE, {"c": 1e-6, "slip": 10.0}, loads({(NODE, RZ): [100.0, 5.0, -30.0]}))
    np.testing.assert_allclose(moved[NODE, RZ], [9e-5, 0.0, -2e-5])


def test_work_lost_in_a_closed_loop() -> None:
    """A loop between ±A loses ∮ δ dτ = 4 c r (A − r): a parallelogram, 2 r wide and 2 (A − r) high."""
    amplitude, slip, c = 300.0, 80.0, 1e-6
    cycle = amplitude * np.concatenate([np.linspace(0, 1, 400), np.linspace(1, -1, 800), np.linspace(-1, 1, 800)])
    turn = c * followed(cycle, slip)
    middle = (turn[400:-1] + turn[401:]) / 2.0
    dissipated = abs(float(middle @ np.diff(cycle[400:])))
    np.testing.assert_allclose(dissipated, 4 * c * slip * (amplitude - slip), rtol=2e-3)


def test_slips_go_by_the_swing_within_a_run_and_not_by_the_weight() -> None:
    torque = np.concatenate([1000.0 + np.linspace(0, 100, 6), -500.0 + np.linspace(0, 40, 6)])
    carried = loads({(NODE, RZ): torque}, order_of([0] * 6 + [1] * 6))
    slips = EFFECT.nonlinear_grid(PLACE, robot_chain(), carried)["slip"]
    assert 1.0 < slips[0] < slips[-1] < 50.0


def test_single_states_have_no_path() -> None:
    chain = robot_chain()
    assert "loading and unloading" in str(EFFECT.lacking(chain, bare_states([0, 1, 2])))
    assert EFFECT.lacking(chain, bare_states([0, 0, 0, 1])) is None


def test_without_weight_the_memory_is_empty() -> None:
    carried = NodeLoads(loads({(NODE, RZ): [100.0]}).wrench, np.zeros((6, 1)), order_of([0]))
    assert displacement(EFFECT, PLACE, {"c": 1.0, "slip": 10.0}, carried)[NODE, RZ, 0] == 90.0


def test_a_drive_that_moved_has_slipped_through() -> None:
    """Link and friction: moving up the drive carries less than the load by the slip, moving down more (τ ∓ r)."""
    torque = np.array([80.0, 80.0, -5.0, 80.0])
    order = replace(order_of([0, 1, 2, 3]), approach=np.tile([1.0, -1.0, 1.0, 0.0], (6, 1)))
    moved = displacement(EFFECT, PLACE, {"c": 2e-6, "slip": 30.0}, loads({(NODE, RZ): torque}, order))[NODE, RZ]
    np.testing.assert_allclose(moved, 2e-6 * np.array([50.0, 110.0, -35.0, 50.0]), rtol=1e-13)


def test_the_form_of_absolute_places_is_the_part_that_is_no_compliance() -> None:
    torque, direction = np.array([80.0, 80.0, -5.0]), np.array([1.0, -1.0, 1.0])
    carried = loads({(NODE, RZ): torque}, replace(order_of([0, 1, 2]), approach=np.tile(direction, (6, 1))))
    form = form_of(EFFECT, ["width"])
    moved = displacement(form, PLACE, {"width": 2.0 * 2e-6 * 30.0}, carried)[NODE, RZ]
    whole = displacement(EFFECT, PLACE, {"c": 2e-6, "slip": 30.0}, carried)[NODE, RZ]
    np.testing.assert_allclose(moved + 2e-6 * torque, whole, rtol=1e-13)
    assert form_of(form, ["c", "slip"]).parameters == EFFECT.parameters


def test_absolute_places_need_both_directions_of_a_drive() -> None:
    states = bare_states([0, 1, 2])
    states = replace(states, runs=tuple(replace(run, measures=StateMeasure.PLACE) for run in states.runs))
    assert "order of approach" in (EFFECT.lacking(robot_chain(), states) or "")
    one_way = replace(states, approach=np.ones((3, 6)))
    form = form_of(EFFECT, ["width"])
    assert isinstance(form, Law)
    assert form.lacking(robot_chain(), one_way)
    both = one_way.approach.copy()
    both[1, 4] = -1.0
    assert form.lacking(robot_chain(), replace(states, approach=both)) is None
    assert EFFECT.lacking(robot_chain(), replace(states, approach=both)) is not None


def test_a_prediction_without_approach_states_that_it_is_the_middle() -> None:
    form = form_of(EFFECT, ["width"])
    (words,) = _left_out([PlacedEffect(form, PLACE, {"width": 5e-4})])
    assert "0.25 mrad to the one or the other side" in words
    others = [PlacedEffect(form, PLACE, {"width": 0.0}), PlacedEffect(EFFECT, PLACE, {"c": 2e-6, "slip": 30.0})]
    assert not list(_left_out(others))
