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
    """CUSUM of every parameter after every campaign.

    Attributes
    ----------
    upper, lower : (n_campaigns, n_parameters), standard deviations between campaigns; sums of increases and decreases,
        0 until a campaign can be scored.
    threshold : alarm where a sum exceeds it.
    """

    upper: Floats
    lower: Floats
    threshold: float

    @property
    def first_alarms(self) -> list[int | None]:
        """Per parameter, the index of the first campaign with an alarm, from `FEWEST_CAMPAIGNS` on; None without."""
        above = np.maximum(self.upper, self.lower) > self.threshold
        above[: FEWEST_CAMPAIGNS - 1] = False
        return [int(np.argmax(column)) if column.any() else None for column in above.T]


def control_chart(values: Floats) -> ControlChart:
    """Return the two-sided, self-starting CUSUM of parameters over campaigns.

    The mean and the variance between campaigns are those of the campaigns before: no known values are needed, and the
    false-alarm rate does not depend on the number of campaigns.

    Parameters
    ----------
    values : (n_campaigns, n_parameters), in order of time; logarithms for stiffnesses and compliances.

    Raises
    ------
    ValueError : a value is not finite.
    """
    if not np.isfinite(values).all():
        raise ValueError("every parameter needs a finite value in every campaign")
    scores = self_starting_scores(values)
    upper, lower = np.zeros_like(values), np.zeros_like(values)
    for campaign in range(1, len(values)):
        upper[campaign] = np.maximum(0.0, upper[campaign - 1] + scores[campaign] - ALLOWANCE)
        lower[campaign] = np.maximum(0.0, lower[campaign - 1] - scores[campaign] - ALLOWANCE)
    return ControlChart(upper, lower, decision_threshold(values.shape[1]))


def self_starting_scores(values: Floats) -> Floats:
    """Return each campaign's deviation from the mean of those before, as a standard normal quantity.

    Hawkins (1987), Self-starting CUSUM charts for location and scale, The Statistician 36: the deviation over its
    estimated standard deviation follows Student's distribution with n - 2 degrees of freedom in campaign n, and is
    turned into the normal quantile of the same probability. The scores of an unchanged robot are independent.

    Parameters
    ----------
    values : (n_campaigns, n_parameters).

    Returns
    -------
    (n_campaigns, n_parameters), dimensionless; 0 in the first two campaigns and where the campaigns before are equal.
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
