"""What the page takes for an effect's part where a device reads one direction, against a tracker's three."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.measurements.load_states import Sigma
from stiffcal.view.gathering.effects import view_effects
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.rod_states import gauge_instead, six_axes_with_beams
from tests.laboratory.simulated_states import joint_springs, played


def test_a_part_is_along_the_gauge_what_it_is_in_all_directions_for_a_tracker() -> None:
    robot = joint_springs(six_axes_with_beams(), SIX_STIFFNESS)
    tracked = played(robot, runs=3, noise=Sigma(translation=10e-6, rotation=20e-6))
    pick, axis = np.arange(0, len(tracked), 2), tracked.run[::2] % 3
    parts = view_effects(robot, gauge_instead(tracked, robot), pick, 3)
    whole = view_effects(robot, tracked, pick, 3)
    assert sum(effect.share for effect in parts) == pytest.approx(1.0, abs=0.02)
    for part, full in zip(parts, whole, strict=True):
        along = np.arange(len(pick)), axis
        np.testing.assert_allclose(part.part[along], full.part[along], rtol=1e-9, atol=1e-15)
        assert np.count_nonzero(part.part) == np.count_nonzero(part.part[along])
    assert max(np.abs(effect.part).max() for effect in parts) > 1e-5
