"""Rods and gauges among the observations: what each reads, what a fit makes of them, what rods tell apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.identify import Settings, fit_rms, identify_parameters
from stiffcal.identification.readings.row_layout import GAUGE, LENGTH
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from tests.laboratory.rod_states import (
    NOISE,
    SWING,
    bending_swing,
    five_rods,
    gauge_instead,
    swinging_robot,
    tilting_bearing,
    with_effect,
    with_rods,
    without_rods,
)
from tests.laboratory.simulated_states import joint_springs, played


def true_robot() -> CompliantRobot:
    return swinging_robot()


def model(robot: CompliantRobot, *added: object) -> CompliantRobot:
    return with_effect(joint_springs(robot.chain), *added)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def rodded() -> LoadStates:
    robot = true_robot()
    return with_rods(played(robot, runs=5, noise=NOISE), robot, five_rods(robot.chain))


def test_the_columns_of_rods_and_gauges_are_their_derivatives(rodded: LoadStates) -> None:
    # in the papers' linear form a column is the derivative exactly
    robot = replace(true_robot(), deformed=False)
    data = observe(gauge_instead(rodded, robot), robot.chain)
    assert data.kind.tolist() == [GAUGE] + 5 * [LENGTH]
    columns = free_columns(robot)
    block = next(evaluate(robot, data, columns))
    for row, column in enumerate(columns):
        one = robot.placed[column.placed]
        name, spec = one.parameter_name(column.symbol), one.effect.spec(column.symbol)
        amplitude = one.amplitude(column.symbol)
        step = 1e-4 * amplitude
        moved = robot.with_values({name: 1.0 / (amplitude + step) if spec.inverse else amplitude + step})
        change = (next(evaluate(moved, data)).predicted - block.predicted) / step
        np.testing.assert_allclose(block.columns[row], change, rtol=1e-6, atol=1e-6 * np.abs(change).max())
    rods = data.rows_of(LENGTH)
    swing = [k for k, column in enumerate(columns) if robot.placed[column.placed].effect.name == "link-beam"]
    assert not block.columns[: swing[0], rods].any(), "joints leave the rods alone"
    assert block.columns[swing[0], rods].any()


def test_devices_of_several_directions_are_one_row(rodded: LoadStates) -> None:
    robot = true_robot()
    states = without_rods(gauge_instead(rodded, robot))
    data = observe(states, robot.chain)
    assert data.measured.shape[0] == 1
    assert data.layout.gauges is not None
    assert sorted(np.unique(data.layout.gauges.gauge)) == [0, 1, 2]
    direction = data.layout.gauges.direction[0, :, data.run == 1]
    np.testing.assert_array_equal(direction, np.tile([0.0, 1.0, 0.0], (len(direction), 1)))
    fit = identify_parameters(
        states,
        model(robot, bending_swing(**SWING)),
        Settings(fixed=frozenset(f"link-beam.swing.{symbol}" for symbol in SWING)),
    )
    assert fit.noise is not None
    assert fit.noise.gauge == pytest.approx(2e-6, rel=0.3)
    assert fit.reduced_chi2 == pytest.approx(1.0, abs=0.4)


def test_rods_distinguish_the_swing_and_say_their_own_noise(rodded: LoadStates) -> None:
    robot = true_robot()
    fit = identify_parameters(rodded, model(robot, bending_swing(), tilting_bearing()))
    for symbol in ("EI2", "EI3"):
        found = fit.parameter(f"link-beam.swing.{symbol}")
        assert found.value == pytest.approx(SWING[symbol], rel=0.02)
        assert found.interval is not None
        assert found.interval[0] < SWING[symbol] < found.interval[1]
    assert fit.noise is not None
    assert fit.noise.length == pytest.approx(1e-6, rel=0.2)
    assert fit_rms(fit)["length"] == pytest.approx(1e-6, rel=0.25)
    alone = identify_parameters(without_rods(rodded), model(robot, bending_swing(), tilting_bearing()))
    assert "length" not in fit_rms(alone)
    with_them, without = (one.parameter("link-beam.swing.EI2").std or np.inf for one in (fit, alone))
    assert without > 5.0 * with_them
