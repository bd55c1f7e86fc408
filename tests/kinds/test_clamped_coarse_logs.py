"""What a log of few readings says of a play: not more than their distance lets it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffcal.kinds.clamped.answers.analysis import analyse_runs
from stiffcal.kinds.clamped.answers.joints import joints_of
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.measurements.load_states import RunInfo

WIDTH, COMPLIANCE, TORQUE = 2e-4, 1e-5, 240.0


@pytest.mark.parametrize("n", [37, 73])
def test_what_lies_between_two_readings_is_not_excluded(n: int) -> None:
    """Three cycles of ± 2.5 mrad, a play of 0.2 mrad: of a description, 12 and 24 readings a cycle find none of it."""
    time = np.linspace(0.0, 3.0, n)
    torque = TORQUE * np.sin(2.0 * np.pi * (time + 0.03))
    angle = COMPLIANCE * torque + 0.5 * WIDTH * np.tanh(torque / 2.5)
    angle += 4e-6 * np.random.default_rng(3).normal(size=n)
    readings = ClampedReadings(
        (RunInfo("a", "clamped"),), np.zeros(n, dtype=np.int64), time, angle[:, None],
        np.full((n, 6), np.nan), torque[:, None], np.array([False]),
    )  # fmt: skip
    chain: Any = SimpleNamespace(
        joint=1, motion=angle[:, None], torque=torque[:, None], source="motor torque", is_excited=True,
        is_distinguishable=True, angle=lambda laws: angle, share_of_others=lambda laws: 0.0, moments_measured=True,
    )  # fmt: skip
    (joint,) = joints_of(analyse_runs([readings], [chain]))
    low, high = joint.play.interval or (0.0, 0.0)
    # as a log of thousands of readings has it: the slope is below a quarter of that outside over this length
    segment = 1.15e-4
    assert high is not None
    assert high > segment
    assert low is None or low < segment
