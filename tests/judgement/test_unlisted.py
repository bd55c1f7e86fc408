"""Laws that nobody has written down: what they are made of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.observation import observe, predicted, rests
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.judgement.numbers import BEYOND_USUAL, USUAL_LOAD
from stiffcal.judgement.unlisted import CROSS_TALK, FUNCTIONS, unlisted_laws
from stiffcal.model.effect import RZ, joint_node
from stiffcal.model.state_order import StateOrder
from tests.laboratory.effect_bench import loads, order_of, robot_chain
from tests.laboratory.simulated_states import medium_robot, played

TORQUE = [-100.0, -50.0, 0.0, 50.0, 100.0]


def of_joint(family: str, order: StateOrder | None = None) -> list[Floats]:
    return FUNCTIONS[family](robot_chain(), 2, loads({(joint_node(2), RZ): TORQUE}, order))


def test_a_contact_gives_by_the_power_two_thirds_either_way() -> None:
    (found,) = of_joint("its own torque to the power 2/3")
    assert found[-1] == pytest.approx(-found[0])
    assert found[-1] / found[-2] == pytest.approx(2.0 ** (2.0 / 3.0))


@pytest.mark.parametrize("follows", ["time", "temperature"])
def test_a_compliance_that_changes_needs_what_it_follows(follows: str) -> None:
    """A weight alone, states without a clock or with one temperature have no such law."""
    family, rising = f"its own torque and the {follows}", np.linspace(0.0, 40.0, 5)
    still, moves = (
        order_of([0] * 5, time=values) if follows == "time" else replace(order_of([0] * 5), kelvin=values)
        for values in (np.full(5, 3.0), rising)
    )
    assert of_joint(family) == of_joint(family, still) == []
    found = of_joint(family, moves)
    assert found[0][-1] == pytest.approx(2.0 * 40.0 / 30.0 * found[0][3])
    assert all(value[0] == 0.0 for value in found)


def test_a_force_that_reads_a_part_of_a_moment_moves_the_readings_as_the_model_says() -> None:
    robot = medium_robot()
    data = observe(played(robot, runs=2, seed=5), robot.chain)
    columns = next(law.columns for law in unlisted_laws(Linearised.about(robot, data)) if law.follows == CROSS_TALK)
    force = float(np.quantile(np.abs(data.wrench[:3]).max(axis=0), USUAL_LOAD))
    usual = float(np.quantile(np.abs(data.wrench[3]), USUAL_LOAD))
    part = 1e-3 * np.clip(data.wrench[3] / usual, -BEYOND_USUAL, BEYOND_USUAL)
    read = data.wrench + np.outer(np.eye(6)[2], force * part)
    moved = replace(data, wrench=read)
    change = predicted(robot, moved, *rests(robot, moved)) - predicted(robot, data, *rests(robot, data))
    # Fz is the third of six, each reads five others; Mx is its third
    assert len(columns) == 30
    assert np.allclose(1e-3 * columns[2 * 5 + 2], change, rtol=0.01, atol=1e-3 * np.abs(change).max())
