"""A run of many states takes no more memory than many runs of few: it is cut wherever its states do not need others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import FIT_TOLERANCE, Observations, evaluate, observe
from stiffcal.identification.fitting.geometry import geometry_effect
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.noise.weights import predict_observations, raw_whitening
from stiffcal.identification.readings import starting
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.simulated_states import cycles_of, medium_robot, played

REACH_M = 4.0
CYCLES = cycles_of(np.eye(3), cycles=40)


def one_run(robot: CompliantRobot) -> Observations:
    return observe(played(robot, runs=1, wrench=[CYCLES], noise=Sigma(15e-6, 2e-5)), robot.chain)


def weighed(data: Observations) -> Whitening:
    return raw_whitening(data, None)


def test_a_run_of_springs_is_cut_and_predicted_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = medium_robot()
    data = one_run(robot)
    whole = predict_observations(robot, data)
    monkeypatch.setattr("stiffcal.model.balance.equilibrium.BLOCK", 100)
    assert [block.states.stop - block.states.start for block in evaluate(robot, data)][:-1] == [100] * (
        data.n_states // 100
    )
    # either way the balance is found to this turn of a joint, at the reach of the robot
    np.testing.assert_allclose(predict_observations(robot, data), whole, rtol=0.0, atol=2.0 * REACH_M * FIT_TOLERANCE)


@pytest.mark.parametrize(("effect", "values"), [("seat-shift", {"state": 30.0, "x": 1e-5}), ("creep", {})])
def test_a_run_stays_whole_where_states_depend_on_others(
    effect: str, values: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = medium_robot()
    place = Place("setup") if effect == "seat-shift" else Place("joints", (2,))
    added = replace(robot, placed=(*robot.placed, PlacedEffect(find_effects()[effect], place, values)))
    data = one_run(robot)
    monkeypatch.setattr("stiffcal.model.balance.equilibrium.BLOCK", 100)
    assert len(list(evaluate(added, data))) == 1


def test_some_states_of_a_long_run_show_what_the_geometry_does(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = medium_robot()
    data = one_run(robot)
    columns = free_columns(robot)
    whole = geometry_effect(robot, data, columns, weighed(data))
    monkeypatch.setattr(starting, "START_STATES", data.n_states // 4)
    chosen = starting.states_of_long_runs(data)
    assert chosen is not None
    assert np.count_nonzero(chosen) == data.n_states // 4
    some = geometry_effect(robot, data, columns, weighed(data))
    # errors of one estimate by millimetres of the whole geometry: no load is left out, as a period would leave it
    size = np.linalg.norm(whole, axis=1)
    np.testing.assert_allclose(np.linalg.norm(some - whole, axis=1) / size, 0.0, atol=0.05)
