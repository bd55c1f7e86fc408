"""Control charts over campaigns: published run lengths, simulated false alarms, delay for a joint that loses 10 %."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.validation.control_chart import (
    CAMPAIGNS_PER_FALSE_ALARM,
    FEWEST_CAMPAIGNS,
    average_run_length,
    control_chart,
    self_starting_scores,
)


@pytest.mark.parametrize(
    ("threshold", "shift", "one_sided"),
    # Montgomery, Introduction to Statistical Quality Control, table of two-sided CUSUMs with k = 1/2: 168 and 465
    # without a shift, 8.38 and 10.4 with a shift of one standard deviation.
    [(4.0, 0.0, 2 * 168.0), (5.0, 0.0, 2 * 465.0), (4.0, 1.0, 8.38), (5.0, 1.0, 10.4)],
)
def test_run_lengths_are_the_published_ones(threshold: float, shift: float, one_sided: float) -> None:
    assert average_run_length(threshold, shift) == pytest.approx(one_sided, rel=5e-3)


def test_scores_of_an_unchanged_robot_are_standard_normal_and_independent() -> None:
    scores = self_starting_scores(np.random.default_rng(1).normal(3.0, 0.2, (12, 20_000)))[2:]
    n = scores.shape[1]
    assert np.abs(scores.mean(axis=1)).max() < 5.0 / np.sqrt(n)
    assert np.abs(scores.var(axis=1) - 1.0).max() < 5.0 * np.sqrt(2.0 / n)
    apart = np.corrcoef(scores) - np.eye(len(scores))
    assert np.abs(apart).max() < 5.0 / np.sqrt(n)


def test_one_false_alarm_in_ten_years_over_all_parameters() -> None:
    """Alarms in 120 campaigns of unchanged robots: the share 1 - exp(-1) of robots, within chance and head start."""
    rng = np.random.default_rng(2)
    n_robots = 400
    alarms = [
        any(
            alarm is not None
            for alarm in control_chart(rng.normal(size=(int(CAMPAIGNS_PER_FALSE_ALARM), 6))).first_alarms
        )
        for _ in range(n_robots)
    ]
    share = 1.0 - np.exp(-1.0)
    # The sums begin at zero and reach their steady state after some ten campaigns: a few per cent fewer alarms.
    assert share - 0.05 - 4 * np.sqrt(share * (1 - share) / n_robots) < np.mean(alarms)
    assert np.mean(alarms) < share + 4 * np.sqrt(share * (1 - share) / n_robots)


def test_delay_for_a_joint_that_loses_a_tenth() -> None:
    """Two per cent between campaigns, two years of monthly campaigns before the loss."""
    rng = np.random.default_rng(3)
    delays = []
    for _ in range(100):
        values = rng.normal(0.0, 0.02, (48, 6))
        values[24:, 2] += np.log(0.9)
        first = control_chart(values).first_alarms[2]
        if first is None or first >= 24:
            delays.append(24 if first is None else first - 23)
    assert len(delays) > 90
    assert np.median(delays) <= 3.0
    assert np.quantile(delays, 0.95) <= 6.0


def test_no_alarm_with_too_few_campaigns() -> None:
    values = np.array([[0.0], [1e-9], [1e3], [1e9]])
    assert len(values) < FEWEST_CAMPAIGNS
    assert control_chart(values).first_alarms == [None]


def test_a_missing_value_is_an_error() -> None:
    with pytest.raises(ValueError):
        control_chart(np.array([[1.0], [np.nan]]))
