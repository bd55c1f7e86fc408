"""What a design minimises, and the loss after each candidate joins it."""

from __future__ import annotations

from enum import Enum

import numpy as np

from stiffcal.arrays import Floats

# Relative improvement below which an exchange is rounding.
LEAST_GAIN = 1e-9


class Criterion(Enum):
    """What a design minimises."""

    DETERMINANT = "determinant"
    """The volume of the joint confidence region of all parameters, or of some (D- or Ds-optimality)."""
    WORST = "worst"
    """The largest relative standard uncertainty of a parameter."""
    PREDICTION = "prediction"
    """The mean variance of predictions at given poses and loads (I- or V-optimality)."""


def inverse(matrix: Floats) -> Floats:
    """Return the inverse of a positive definite matrix, symmetric to the last bit."""
    scale = 1.0 / np.sqrt(np.diagonal(matrix))
    lower = np.linalg.inv(np.linalg.cholesky(matrix * scale[:, None] * scale))
    half = lower * scale
    return np.asarray(half.T @ half)


def losses_after(factors: Floats, covariance: Floats, criterion: Criterion, rows: Floats) -> Floats:
    """Return (N,) the logarithm of the loss after each candidate joins, by updates of the covariance of rank r.

    With G = A C Aᵀ and Y = (I + G)^(-1/2) A C the covariance becomes C − YᵀY (Woodbury). The determinant of all becomes
    det C / det(I + G); that of some is it over the determinant of the others, were these known.
    """
    moved = factors @ covariance
    gram = moved @ np.swapaxes(factors, 1, 2) + np.eye(factors.shape[1])
    lower = np.linalg.cholesky(gram)
    if criterion is Criterion.DETERMINANT:
        gain = 2.0 * np.sum(np.log(np.diagonal(lower, axis1=1, axis2=2)), axis=1)
        others = ~rows.any(axis=0)
        if others.any():
            known = inverse(inverse(covariance)[np.ix_(others, others)])
            part = factors[:, :, others]
            inside = np.linalg.cholesky(part @ known @ np.swapaxes(part, 1, 2) + np.eye(factors.shape[1]))
            gain = gain - 2.0 * np.sum(np.log(np.diagonal(inside, axis1=1, axis2=2)), axis=1)
        return np.asarray((volume(covariance, rows) - gain) / (2 * len(rows)))
    update = np.linalg.solve(lower, moved)
    if criterion is Criterion.WORST:
        variances = variances_of(covariance, rows) - np.sum((update @ rows.T) ** 2, axis=1)
        # Of equal worst parameters the mean decides: otherwise nothing shows which exchange helps.
        worst = np.max(variances, axis=1)
        return np.asarray(0.5 * np.log(worst) + 1e-6 * np.mean(variances, axis=1) / worst)
    mean = np.sum((rows @ covariance) * rows) - np.sum((update @ rows.T) ** 2, axis=(1, 2))
    return np.asarray(0.5 * np.log(np.maximum(mean, np.finfo(float).tiny)))


def volume(covariance: Floats, rows: Floats) -> float:
    """Return the logarithm of the determinant of the covariance of rows (q, p)."""
    return float(np.linalg.slogdet(rows @ covariance @ rows.T)[1])


def variances_of(covariance: Floats, rows: Floats) -> Floats:
    """Return (q,) the variances of rows (q, p)."""
    return np.asarray(np.sum((rows @ covariance) * rows, axis=1))
