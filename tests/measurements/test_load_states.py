"""Load states hold together: every field has a row for each state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stiffcal.measurements.load_states import PER_STATE
from tests.laboratory.robots import force_sensor_setup, six_axes
from tests.laboratory.unread_states import unread_states

STATES = unread_states(np.zeros((2, 6)), np.zeros((2, 5, 6)), force_sensor_setup(six_axes(), 0.0))


@pytest.mark.parametrize("name", PER_STATE[1:])
def test_a_field_of_another_number_of_states_is_refused(name: str) -> None:
    values = getattr(STATES, name)
    changed: dict[str, Any] = {name: np.concatenate([values, values[:1]]) if values.size else np.zeros((11, 1))}
    with pytest.raises(ValueError, match=name):
        replace(STATES, **changed)


def test_a_selection_takes_the_same_rows_of_every_field() -> None:
    chosen = STATES.select(np.arange(10) % 2 == 0)
    assert len(chosen) == 5
    assert chosen.row.tolist() == [1, 3, 5, 7, 9]
