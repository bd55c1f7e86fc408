"""seat-shift: a step from one state to the end of its run."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.effects.seat_shift import SeatShift
from stiffcal.model.effect import Observed, Place, StateOrder
from tests.laboratory.effect_bench import bare_states, loads, order_of, robot_chain

EFFECT = SeatShift()
PLACE = Place("setup")
ORDER = order_of([0, 0, 0, 1, 1, 1, 2, 2])


def step(state: float, order: StateOrder = ORDER) -> list[float]:
    observed = Observed(np.zeros((1, 6, len(order.run))), order)
    columns = EFFECT.observation_columns(PLACE, observed, {"state": state})
    for component, symbol in enumerate("xyz"):
        rest = np.delete(columns[symbol][0], component, axis=0)
        assert not rest.any()
    np.testing.assert_array_equal(columns["x"][0, 0], columns["z"][0, 2])
    return list(columns["y"][0, 1])


@pytest.mark.parametrize(
    ("state", "wanted"),
    [(2.0, [0, 1, 1, 0, 0, 0, 0, 0]), (5.0, [0, 0, 0, 0, 1, 1, 0, 0]), (8.0, [0] * 7 + [1]), (99.0, [0] * 8)],
)
def test_to_the_end_of_the_run_and_no_further(state: float, wanted: list[float]) -> None:
    assert step(state) == wanted


def test_blocks_and_states_set_aside() -> None:
    """Cut at runs, as the fit does; state 5 set aside: the step begins at state 6 of the same run."""
    tail = ORDER.block(slice(3, None))
    assert step(2.0, tail) == [0.0] * 5
    assert step(5.0, tail) == [0.0, 1.0, 1.0, 0.0, 0.0]
    assert step(5.0, ORDER.block(np.array([0, 1, 2, 3, 5, 6, 7]))) == [0, 0, 0, 0, 1, 0, 0]


def test_every_state_but_the_first_of_a_run_is_tried() -> None:
    grid = EFFECT.nonlinear_grid(PLACE, robot_chain(), loads({(0, 0): np.zeros(8)}, ORDER))["state"]
    assert grid.tolist() == [2, 3, 5, 6, 8]
    assert EFFECT.spec("state").discrete


def test_single_states_show_no_step() -> None:
    assert EFFECT.lacking(robot_chain(), bare_states([0, 1, 2])) is not None
    assert EFFECT.lacking(robot_chain(), bare_states([0, 0, 0])) is None
