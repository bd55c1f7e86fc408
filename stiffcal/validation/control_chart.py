"""Control charts of the parameters of one robot over many campaigns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats

FEWEST_CAMPAIGNS = 5
"""Below this many campaigns the variance between campaigns is too uncertain for an alarm."""
CAMPAIGNS_PER_FALSE_ALARM = 120.0
"""One false alarm in ten years of monthly campaigns, over all parameters together."""
ALLOWANCE = 0.5
"""Half of the shift that the chart detects fastest, in standard deviations between campaigns."""
_NODES = 60


@dataclass(frozen=True)
class ControlChart:
    """CUSUM of one parameter after every campaign.

    Attributes
    ----------
    upper, lower : (n_campaigns,) standard deviations between campaigns; sums of increases and decreases, 0 until a
        campaign can be scored.
    threshold : alarm where a sum exceeds it.
    first_judged : index of the first campaign that can raise an alarm.
    first_alarm : index of the first campaign with an alarm; None without one.
    changed_from : index of the first campaign after the change; None without an alarm.
    """

    upper: Floats
    lower: Floats
    threshold: float
    first_judged: int
    first_alarm: int | None
    changed_from: int | None


def control_chart(values: Floats, n_parameters: int, deviation: Floats | None = None) -> ControlChart:
    """Return the two-sided, self-starting CUSUM of one parameter over campaigns.

    The mean, and where it is not known the variance, are those of the campaigns before: the false-alarm rate does not
    depend on the number of campaigns.

    Parameters
    ----------
    values : (n_campaigns,) in order of time; logarithms for stiffnesses and compliances.
    n_parameters : how many parameters are judged together.
    deviation : (n_campaigns,) standard deviation of each campaign's value, what varies between campaigns included; None
        where it is not known: then the first `FEWEST_CAMPAIGNS` raise no alarm but in the last of them.

    Raises
    ------
    ValueError : a value is not finite.
    """
    if not np.isfinite(values).all():
        raise ValueError("a parameter needs a finite value in every campaign")
    scores = self_starting_scores(values) if deviation is None else scores_of_known_variance(values, deviation)
    upper, lower = cusum(scores)
    first, threshold = FEWEST_CAMPAIGNS - 1 if deviation is None else 1, decision_threshold(n_parameters)
    above = np.maximum(upper, lower) > threshold
    above[:first] = False
    if not above.any():
        return ControlChart(upper, lower, threshold, first, None, None)
    alarm = int(np.argmax(above))
    weight = np.ones_like(values) if deviation is None else 1.0 / deviation**2
    return ControlChart(upper, lower, threshold, first, alarm, change_point(values[: alarm + 1], weight[: alarm + 1]))


def cusum(scores: Floats) -> tuple[Floats, Floats]:
    """Return the sums of increases and of decreases beyond the allowance, which begin anew at zero.

    Parameters
    ----------
    scores : (n_campaigns, ...) standard normal for an unchanged robot.
    """
    upper, lower = np.zeros_like(scores), np.zeros_like(scores)
    for campaign in range(1, len(scores)):
        upper[campaign] = np.maximum(0.0, upper[campaign - 1] + scores[campaign] - ALLOWANCE)
        lower[campaign] = np.maximum(0.0, lower[campaign - 1] - scores[campaign] - ALLOWANCE)
    return upper, lower


def change_point(values: Floats, weight: Floats) -> int:
    """Return the index of the first value after a step of the mean.

    The maximum-likelihood estimate for normal values: Pignatiello and Samuel (2001), Estimation of the change point of
    a normal process mean in SPC applications, Journal of Quality Technology 33.

    Parameters
    ----------
    values, weight : (n,) in order of time, n at least 2; weights are inverse variances, up to a common factor.
    """
    before, before_sum = np.cumsum(weight)[:-1], np.cumsum(weight * values)[:-1]
    after, after_sum = weight.sum() - before, (weight * values).sum() - before_sum
    return int(np.argmax((after_sum / after - before_sum / before) ** 2 / (1.0 / before + 1.0 / after))) + 1


def self_starting_scores(values: Floats) -> Floats:
    """Return each campaign's deviation from the mean of those before, as a standard normal quantity.

    Hawkins (1987), Self-starting CUSUM charts for location and scale, The Statistician 36: the deviation over its
    estimated standard deviation follows Student's distribution with n - 2 degrees of freedom in campaign n, and is
    turned into the normal quantile of the same probability. The scores of an unchanged robot are independent.

    Parameters
    ----------
    values : (n_campaigns, ...).

    Returns
    -------
    (n_campaigns, ...), dimensionless; 0 in the first two campaigns and where the campaigns before are equal.
    """
    from scipy.special import ndtri, stdtr

    scores = np.zeros_like(values)
    for before in range(2, len(values)):
        earlier = values[:before]
        spread = earlier.std(axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / before)
        deviation = values[before] - earlier.mean(axis=0)
        ratio = np.divide(deviation, spread, out=np.zeros_like(deviation), where=spread > 0.0)
        # The lower tail keeps its digits where the probability of the upper one rounds to 1.
        scores[before] = -np.sign(ratio) * ndtri(np.maximum(stdtr(before - 1.0, -np.abs(ratio)), 1e-300))
    return scores


def scores_of_known_variance(values: Floats, deviation: Floats) -> Floats:
    """Return each campaign's deviation from the weighted mean of those before, over its standard deviation.

    The recursive residuals of Brown, Durbin and Evans (1975), Techniques for testing the constancy of regression
    relationships over time, J. R. Stat. Soc. B 37, for a constant: standard normal and independent for an unchanged
    robot.

    Parameters
    ----------
    values, deviation : (n_campaigns,) and their standard deviations.
    """
    weight = 1.0 / deviation**2
    scores = np.zeros_like(values)
    for before in range(1, len(values)):
        mean = np.average(values[:before], weights=weight[:before])
        scores[before] = (values[before] - mean) / np.sqrt(deviation[before] ** 2 + 1.0 / weight[:before].sum())
    return scores


def decision_threshold(n_parameters: int) -> float:
    """Return the threshold with one false alarm in `CAMPAIGNS_PER_FALSE_ALARM` over all parameters together.

    Each parameter has two one-sided sums. Correlated parameters raise fewer false alarms than independent ones.
    """
    from scipy.optimize import brentq

    wanted = CAMPAIGNS_PER_FALSE_ALARM * 2 * n_parameters
    return float(brentq(lambda h: np.log(average_run_length(h) / wanted), 0.5, 20.0, xtol=1e-9))


def average_run_length(threshold: float, shift: float = 0.0) -> float:
    """Return the mean number of campaigns until a one-sided sum exceeds the threshold.

    Page (1954), Continuous inspection schemes, Biometrika 41: the integral equation of the run length, solved by
    Gauss-Legendre quadrature.

    Parameters
    ----------
    threshold : standard deviations between campaigns.
    shift : mean of the scores, standard deviations between campaigns; 0 for an unchanged robot.
    """
    from scipy.special import ndtr

    points, weights = np.polynomial.legendre.leggauss(_NODES)
    points, weights = 0.5 * threshold * (points + 1.0), 0.5 * threshold * weights
    starts = np.append(0.0, points)
    step = points[None, :] - starts[:, None] + ALLOWANCE - shift
    onward = weights * np.exp(-0.5 * step**2) / np.sqrt(2.0 * np.pi)
    to_zero = ndtr(ALLOWANCE - shift - starts)
    system = np.eye(len(starts)) - np.column_stack([to_zero, onward])
    return float(np.linalg.solve(system, np.ones(len(starts)))[0])
