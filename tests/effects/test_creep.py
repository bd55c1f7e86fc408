"""creep: Kelvin–Voigt over the run's time stamps, against the analytic solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.effects.creep import Creep
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.effect import RZ, Place, StateOrder, joint_node
from stiffcal.model.state_order import PoseHistory
from tests.laboratory.effect_bench import bare_states, displacement, loads, order_of, robot_chain

EFFECT = Creep()
PLACE = Place("joints", (2,))
NODE = joint_node(2)


def crept(torque: Floats, order: StateOrder, time: float, weight: float = 0.0) -> Floats:
    carried = loads({(NODE, RZ): torque}, order, {(NODE, RZ): weight})
    return np.asarray(displacement(EFFECT, PLACE, {"c": 1.0, "time": time}, carried)[NODE, RZ])


def test_a_held_load_comes_exponentially() -> None:
    """Loaded right after t = 0 and held: c τ (1 − e^{−t/T}), whatever the steps."""
    stamps = np.array([0.0, 1.0, 3.0, 3.5, 20.0, 60.0])
    found = crept(np.array([0.0, *[100.0] * 5]), order_of([0] * 6, stamps), 15.0)
    np.testing.assert_allclose(found, 100.0 * (1.0 - np.exp(-stamps / 15.0)), rtol=1e-13)


def test_and_goes_exponentially() -> None:
    stamps = np.array([0.0, 40.0, 50.0, 80.0])
    found = crept(np.array([0.0, 100.0, 0.0, 0.0]), order_of([0] * 4, stamps), 20.0)
    top = 100.0 * (1.0 - np.exp(-2.0))
    np.testing.assert_allclose(found[1:], [top, top * np.exp(-0.5), top * np.exp(-2.0)], rtol=1e-13)


def test_fine_steps_follow_a_sine_as_the_differential_equation_says() -> None:
    """T x' = sin(ωt) − x from rest: (sin ωt − ωT cos ωt + ωT e^{−t/T}) / (1 + ω²T²)."""
    time, omega = 5.0, 0.8
    stamps = np.linspace(0.0, 30.0, 12001)
    # load i acts from stamp i − 1 to stamp i: its value at the middle of the step makes the sum second-order exact
    torque = np.sin(omega * (stamps - stamps[1] / 2.0))
    torque[0] = 0.0
    found = crept(torque, order_of([0] * len(stamps), stamps), time)
    exact = np.sin(omega * stamps) - omega * time * (np.cos(omega * stamps) - np.exp(-stamps / time))
    np.testing.assert_allclose(found, exact / (1.0 + (omega * time) ** 2), atol=1e-6)


def test_weight_has_acted_for_long() -> None:
    stamps = [0.0, 10.0, 20.0]
    found = crept(np.full(3, 70.0), order_of([0] * 3, stamps), 15.0, weight=70.0)
    np.testing.assert_allclose(found, 70.0, rtol=1e-14)


def test_known_holds_count_instead_of_the_whole_step() -> None:
    """100 s between stamps, but the load was held for 5 s only before its reading."""
    order = order_of([0, 0], [0.0, 100.0], hold=[np.nan, 5.0])
    np.testing.assert_allclose(crept(np.array([0.0, 100.0]), order, 10.0)[1], 100.0 * (1.0 - np.exp(-0.5)))
    # the load before it acts on until the new one comes: up for 20 s, on for 7 s more, then 3 s of the next
    order = order_of([0, 0, 0], [0.0, 20.0, 30.0], hold=[np.nan, np.nan, 3.0])
    before = 50.0 * (1.0 - np.exp(-2.7))
    after = 100.0 + (before - 100.0) * np.exp(-0.3)
    np.testing.assert_allclose(crept(np.array([0.0, 50.0, 100.0]), order, 10.0)[2], after, rtol=1e-13)
    single = order_of([0], [0.0], hold=[5.0])
    np.testing.assert_allclose(crept(np.array([100.0]), single, 10.0), 100.0 * (1.0 - np.exp(-0.5)))


def test_runs_begin_anew() -> None:
    stamps = [0.0, 10.0, 20.0, 1000.0, 1010.0, 1020.0]
    torque = np.array([0.0, 50.0, 0.0] * 2)
    found = crept(torque, order_of([0, 0, 0, 1, 1, 1], stamps), 15.0)
    np.testing.assert_allclose(found[3:], found[:3])


def test_without_time_the_load_is_held_for_ever() -> None:
    carried = loads({(NODE, RZ): [30.0]})
    assert displacement(EFFECT, PLACE, {"c": 1.0, "time": 10.0}, carried)[NODE, RZ, 0] == 30.0


def test_what_is_lacking() -> None:
    chain = robot_chain()
    assert "time stamps" in str(EFFECT.lacking(chain, bare_states([0, 0, 0])))
    timed = bare_states([0, 1, 2], time=np.arange(3.0))
    assert "several states" in str(EFFECT.lacking(chain, timed))
    assert EFFECT.lacking(chain, bare_states([0, 0, 0], time=np.arange(3.0))) is None


def test_times_from_the_shortest_step_to_the_longest_run() -> None:
    carried = loads({(NODE, RZ): np.ones(6)}, order_of([0, 0, 0, 1, 1, 1], [0, 6, 12, 1000, 1003, 1090]))
    times = EFFECT.nonlinear_grid(PLACE, robot_chain(), carried)["time"]
    np.testing.assert_allclose(times[[0, -1]], [1.0, 90.0])


def history(torque: Floats, stamps: Floats, index: list[int], segment: list[int] | None = None) -> PoseHistory:
    carried = np.zeros((6, len(torque)))
    carried[1] = torque
    segments = np.zeros(len(torque), dtype=np.int64) if segment is None else np.array(segment)
    return PoseHistory(carried, segments, stamps, np.full(len(torque), np.nan), np.array(index))


def test_poses_that_follow_each_other_are_loads_though_some_are_left_out() -> None:
    stamps, torque = np.array([0.0, 20.0, 40.0, 60.0, 75.0]), np.array([10.0, 90.0, -30.0, 40.0, 40.0])
    whole = crept(torque, order_of([0] * 5, stamps), 25.0, weight=10.0)
    # each row is a run of its own, and two of them are not in the fit
    kept = [1, 3, 4]
    order = replace(order_of([0, 1, 2], stamps[kept]), history=history(torque, stamps, kept))
    np.testing.assert_allclose(crept(torque[kept], order, 25.0), whole[kept], rtol=1e-13)
    # a part of them still does
    np.testing.assert_allclose(crept(torque[[3]], order.block(slice(1, 2)), 25.0), whole[[3]], rtol=1e-13)


def test_an_interrupted_sequence_begins_relaxed() -> None:
    stamps, torque = np.array([0.0, 20.0, 40.0, 60.0]), np.array([10.0, 90.0, -30.0, 40.0])
    order = replace(order_of([0, 1, 2, 3], stamps), history=history(torque, stamps, [0, 1, 2, 3], [0, 0, 1, 1]))
    found = crept(torque, order, 25.0)
    np.testing.assert_allclose(found[[0, 2]], torque[[0, 2]], rtol=1e-13)
    np.testing.assert_allclose(found[3], 40.0 + (-30.0 - 40.0) * np.exp(-20.0 / 25.0), rtol=1e-13)


def test_absolute_places_need_the_order_of_approach() -> None:
    states = bare_states([0, 1, 2], time=[0.0, 20.0, 40.0])
    runs = tuple(replace(run, measures=StateMeasure.PLACE) for run in states.runs)
    held = replace(states, runs=runs, hold=np.full(3, 5.0))
    assert "order of approach" in (EFFECT.lacking(robot_chain(), held) or "")
    ordered = replace(held, runs=tuple(replace(run, direct=True) for run in runs))
    assert EFFECT.lacking(robot_chain(), ordered) is None


def test_a_time_that_is_missing_costs_its_own_run_alone() -> None:
    """That run counts as relaxed; the others are tried, and the times of all that are known make the grid."""
    stamps = [0.0, 10.0, 30.0, 0.0, np.nan, 30.0]
    order, torque = order_of([0, 0, 0, 1, 1, 1], stamps), np.array([0.0, 100.0, 100.0, 0.0, 50.0, 70.0])
    found = crept(torque, order, 20.0)
    np.testing.assert_allclose(found[:3], crept(torque[:3], order_of([0] * 3, stamps[:3]), 20.0), rtol=1e-13)
    np.testing.assert_array_equal(found[3:], torque[3:])
    times = EFFECT.nonlinear_grid(PLACE, robot_chain(), loads({(NODE, RZ): torque}, order))["time"]
    np.testing.assert_allclose(times[[0, -1]], [10.0 / 3.0, 30.0])


def test_poses_are_tried_whatever_the_times_of_other_runs() -> None:
    stamps, torque = np.array([0.0, 20.0, 40.0]), np.array([10.0, 90.0, -30.0])
    order = replace(
        order_of([0, 1, 2, 3, 3], [*stamps, np.nan, np.nan]), history=history(torque, stamps, [0, 1, 2, -1, -1])
    )
    carried = np.array([*torque, 5.0, 6.0])
    known = replace(order_of([0, 1, 2], stamps), history=history(torque, stamps, [0, 1, 2]))
    np.testing.assert_allclose(crept(carried, order, 25.0), [*crept(torque, known, 25.0), 5.0, 6.0], rtol=1e-13)
    assert EFFECT.nonlinear_grid(PLACE, robot_chain(), loads({(NODE, RZ): carried}, order))["time"].size


def test_what_is_lacking_is_never_also_tried() -> None:
    """Where no time can be tried the effect states why, and where it states nothing there are times."""
    runs = [0, 0, 0]
    some = bare_states(runs, time=[0.0, np.nan, 2.0])
    assert "time stamp of each" in (EFFECT.lacking(robot_chain(), some) or "")
    rows = bare_states([0, 1, 2], time=[0.0, np.nan, np.nan])
    absolute = tuple(replace(run, measures=StateMeasure.PLACE, direct=k > 0) for k, run in enumerate(rows.runs))
    assert 'approach = "direct"' in (EFFECT.lacking(robot_chain(), replace(rows, runs=absolute)) or "")
    two = bare_states([0, 0, 1, 1], time=[0.0, 2.0, 0.0, np.nan])
    assert EFFECT.lacking(robot_chain(), two) is None
