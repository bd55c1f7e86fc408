"""thermal-drift: rate times time, or temperature, since the run's reference."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.thermal_drift import ThermalDrift
from stiffcal.model.effect import Observed, Place
from tests.laboratory.effect_bench import bare_states, order_of, robot_chain

EFFECT = ThermalDrift()
PLACE = Place("setup")


def test_time_since_each_runs_reference() -> None:
    order = order_of([0, 0, 1, 1], [100.0, 160.0, 900.0, 1000.0])
    columns = EFFECT.observation_columns(PLACE, Observed(np.ones((2, 6, 4)), order), {})
    for component, symbol in enumerate(("x", "y", "z", "rx", "ry", "rz")):
        wanted = np.zeros((2, 6, 4))
        wanted[:, component] = [0.0, 60.0, 0.0, 100.0]
        np.testing.assert_array_equal(columns[symbol], wanted)


def test_temperature_where_it_is_logged() -> None:
    order = order_of([0, 0, 0], [0.0, 10.0, 20.0], temperature=[0.0, 0.5, 2.0])
    column = EFFECT.observation_columns(PLACE, Observed(np.zeros((1, 6, 3)), order), {})["z"]
    np.testing.assert_array_equal(column[0, 2], [0.0, 0.5, 2.0])


def test_lacking_time_and_temperature() -> None:
    chain = robot_chain()
    assert "time stamps or a temperature" in str(EFFECT.lacking(chain, bare_states([0, 0, 1])))
    assert EFFECT.lacking(chain, bare_states([0, 1, 2], time=np.arange(3.0))) is not None
    assert EFFECT.lacking(chain, bare_states([0, 0, 1], time=np.arange(3.0))) is None
    warm = bare_states([0, 0, 1], temperature=np.array([[20.0], [21.0], [21.0]]))
    assert EFFECT.lacking(chain, warm) is None
