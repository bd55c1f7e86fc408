"""Confidence intervals of rates: exact ones (Clopper and Pearson, Biometrika 26, 1934)."""

from __future__ import annotations


def clopper_pearson(good: int, count: int, level: float = 0.95) -> tuple[float, float]:
    """Return the exact two-sided interval of a binomial rate; 0 to 1 where nothing was counted."""
    from scipy.stats import binomtest

    if count == 0:
        return 0.0, 1.0
    interval = binomtest(good, count).proportion_ci(confidence_level=level, method="exact")
    return float(interval.low), float(interval.high)


def highest(count: int, total: int) -> float:
    """Return the one-sided 95 % upper limit of a rate."""
    from scipy.special import betaincinv

    return 1.0 if count >= total else float(betaincinv(count + 1, total - count, 0.95))
