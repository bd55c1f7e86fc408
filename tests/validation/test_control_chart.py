"""Control charts over campaigns: published run lengths, simulated false alarms, delay for a joint that loses 10 %."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Booleans, Floats
from stiffcal.validation.control_chart import (
    CAMPAIGNS_PER_FALSE_ALARM,
    FEWEST_CAMPAIGNS,
    average_run_length,
    control_chart,
    cusum,
    decision_threshold,
    scores_of_known_variance,
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


def alarms_of(scores: Floats) -> Booleans:
    """Return (n_campaigns, n_robots) where any of six parameters (n_campaigns, n_robots, 6) raises an alarm."""
    upper, lower = cusum(scores)
    above = np.maximum(upper, lower) > decision_threshold(6)
    above[: FEWEST_CAMPAIGNS - 1] = False
    return np.asarray(above.any(axis=2))


def test_one_false_alarm_in_ten_years_over_all_parameters() -> None:
    """Alarms in 120 campaigns of unchanged robots: the share 1 - exp(-1) of robots, within chance and head start."""
    n_robots = 1000
    values = np.random.default_rng(2).normal(size=(int(CAMPAIGNS_PER_FALSE_ALARM), n_robots, 6))
    share, expected = alarms_of(self_starting_scores(values)).any(axis=0).mean(), 1.0 - np.exp(-1.0)
    chance = 4 * np.sqrt(expected * (1 - expected) / n_robots)
    # The sums begin at zero and reach their steady state after some ten campaigns: a few per cent fewer alarms.
    assert expected - 0.05 - chance < share < expected + chance


@pytest.mark.parametrize(("deviation", "median", "most"), [(0.01, 1.0, 2.0), (0.02, 3.0, 4.0), (0.03, 4.0, 6.0)])
def test_delay_for_a_joint_that_loses_a_tenth(deviation: float, median: float, most: float) -> None:
    """Two years of monthly campaigns before the loss; the page `Watch a robot age` prints these delays."""
    values = np.random.default_rng(3).normal(0.0, deviation, (48, 300, 6))
    values[24:, :, 2] -= np.log(0.9)
    alarms = alarms_of(self_starting_scores(values))
    since = alarms[24:, ~alarms[:24].any(axis=0)]
    assert since.any(axis=0).all()
    delays = since.argmax(axis=0) + 1
    assert np.median(delays) <= median
    assert np.quantile(delays, 0.95, method="higher") <= most


def test_scores_of_a_stated_variance_are_standard_normal_and_independent() -> None:
    deviation = np.array([0.02, 0.05, 0.01, 0.03, 0.02, 0.04])
    values = np.random.default_rng(5).normal(7.0, deviation, (4000, 6))
    scores = np.array([scores_of_known_variance(row, deviation) for row in values])[:, 1:]
    assert np.abs(scores.mean(axis=0)).max() < 5.0 / np.sqrt(4000)
    assert np.abs(np.cov(scores.T) - np.eye(5)).max() < 5.0 * np.sqrt(2.0 / 4000)


def test_a_step_is_dated_and_an_alarm_needs_five_campaigns_or_a_stated_variance() -> None:
    steady = np.array([0.0, 0.01, -0.01, 0.005, -0.005, 0.008, -0.008, 0.0])
    stepped = np.append(steady, [0.1, 0.105, 0.11])
    chart = control_chart(stepped, n_parameters=6)
    assert chart.first_alarm is not None
    assert chart.changed_from == 8
    few = np.array([0.0, 1e-9, 1e3, 1e9])
    assert len(few) < FEWEST_CAMPAIGNS
    assert control_chart(few, n_parameters=1).first_alarm is None
    known = control_chart(np.array([0.0, 0.01, 0.1]), 6, np.full(3, 0.01))
    assert (known.first_alarm, known.changed_from) == (2, 2)


def test_a_missing_value_is_an_error() -> None:
    with pytest.raises(ValueError):
        control_chart(np.array([1.0, np.nan]), 1)


def test_a_step_is_dated_where_the_weighted_squares_are_least() -> None:
    """Campaigns known to 0.01 and to 0.06: the date of most likelihood, by trying all of them."""
    rng = np.random.default_rng(8)
    dates = []
    for _ in range(60):
        deviation = rng.choice([0.01, 0.06], 12)
        values = rng.normal(0.0, deviation) + 0.08 * (np.arange(12) >= 6)
        chart = control_chart(values, 1, deviation)
        if chart.first_alarm is None or chart.first_alarm < 3:
            continue
        until, weight = values[: chart.first_alarm + 1], 1.0 / deviation[: chart.first_alarm + 1] ** 2
        squares = [
            sum(
                float(np.sum(w * (v - np.average(v, weights=w)) ** 2))
                for v, w in ((until[:k], weight[:k]), (until[k:], weight[k:]))
            )
            for k in range(1, len(until))
        ]
        dates.append((chart.changed_from, 1 + int(np.argmin(squares))))
    assert len(dates) > 20
    assert [found for found, _ in dates] == [best for _, best in dates]
