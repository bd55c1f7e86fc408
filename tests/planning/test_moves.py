"""Joint moves between runs."""

from __future__ import annotations

import numpy as np

from stiffcal.planning.candidates import Cell, is_free
from stiffcal.planning.moves import move_is_free, ways_between
from tests.laboratory.robots import force_sensor_setup, six_axes

CHAIN = six_axes()
TIPS = force_sensor_setup(CHAIN).targets[:1]
LIMITS = np.radians([[-170, 170], [-140, 0], [-110, 150], [-200, 200], [-120, 120], [-300, 300]])
BOX = Cell(LIMITS, np.array([[[0.6, -0.3, 0.3], [1.6, 0.3, 2.0]]]), 0.1, None, None)
START, MIDDLE, END = np.radians([[-60, -60, 10, 0, 30, 0], [0, -60, 10, 0, 30, 0], [60, -60, 10, 0, 30, 0]])


def test_a_move_through_a_box_is_not_free_though_its_ends_are() -> None:
    assert is_free(CHAIN, BOX, TIPS, np.stack([START, MIDDLE, END])).tolist() == [True, False, True]
    assert not move_is_free(CHAIN, BOX, TIPS, START, END)
    assert not move_is_free(CHAIN, BOX, TIPS, END, START)
    assert move_is_free(CHAIN, Cell(LIMITS, np.zeros((0, 2, 3)), 0.1, None, None), TIPS, START, END)


def test_a_way_leads_around_the_box() -> None:
    back = np.radians([0, -135, 60, 0, 30, 0])
    none, around, unnecessary = ways_between(
        CHAIN, BOX, TIPS, np.stack([START, START, END, END]), np.stack([MIDDLE, back])
    )
    assert none is not None
    assert none.shape == (0, 6)
    assert around is not None
    np.testing.assert_array_equal(around, back[None])
    assert move_is_free(CHAIN, BOX, TIPS, START, around[0])
    assert unnecessary is not None
    assert len(unnecessary) == 0


def test_where_no_way_is_free_there_is_none() -> None:
    assert ways_between(CHAIN, BOX, TIPS, np.stack([START, END]), MIDDLE[None]) == [None]
