"""Functions of what a drive carried before."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.judgement.memory import of_memory
from stiffcal.judgement.numbers import AVERAGES

ONE_RUN = np.zeros(6, dtype=np.int64)
LAST, DIRECTION = len(AVERAGES), len(AVERAGES) + 1


def test_a_load_that_stays_has_no_past() -> None:
    assert not np.any(of_memory(np.full(6, 0.7), ONE_RUN))


def test_states_that_stand_alone_have_none() -> None:
    assert not np.any(of_memory(np.arange(6.0), None))


def test_what_was_carried_last_and_the_way_since() -> None:
    functions = of_memory(np.array([0.0, 0.5, 1.0, 0.5, 0.0, 0.0]), ONE_RUN)
    assert functions[LAST] == pytest.approx([0.0, -0.5, -0.5, 0.5, 0.5, 0.0])
    assert functions[DIRECTION] == pytest.approx([0.0, 1.0, 1.0, -1.0, -1.0, -1.0])
    assert functions[DIRECTION + 2] == pytest.approx([0.0, -0.5, -1.0, 0.5, 1.0, 1.0])


def test_a_change_within_noise_is_no_turn() -> None:
    functions = of_memory(np.array([0.0, 1.0, 0.99, 1.0, 0.99, 1.0]), ONE_RUN)
    assert functions[DIRECTION] == pytest.approx([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])


def test_each_run_has_a_past_of_its_own() -> None:
    load = np.array([0.2, 1.0, 0.3, 0.2, 1.0])
    both = np.array(of_memory(load, np.array([4, 4, 4, 9, 9])))
    assert both[:, :2] == pytest.approx(both[:, 3:])
