"""clock-offset: y_seen(t) = y(t + offset); not for load states."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.clock_offset import ClockOffset
from tests.effects.bench import bare_states, robot_chain

EFFECT = ClockOffset()


def test_a_ramp_is_seen_ahead() -> None:
    time = np.linspace(0.0, 10.0, 101)
    seen = EFFECT.seen_at(time, 3.0 * time, 0.25)
    np.testing.assert_allclose(seen[:90] - 3.0 * time[:90], 0.75)
    np.testing.assert_array_equal(EFFECT.seen_at(time, 3.0 * time, 0.0), 3.0 * time)


def test_load_states_hold_no_motion() -> None:
    assert "sweeps or ramps" in str(EFFECT.lacking(robot_chain(), bare_states([0, 0, 0])))
