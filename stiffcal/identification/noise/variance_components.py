"""Variances of most likelihood: what makes up the scatter of repeats (Searle, Casella and McCulloch 1992, ch. 6)."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

# Shares of the total variance that still move by less than this are settled: a hundredth of what repeats can resolve.
SETTLED = 1e-4
MOST_STEPS = 200
ROUNDING = 1e-10


def variance_components(
    differences: Floats, levers: Floats, row_kinds: Integers, basis: Floats | None = None
) -> Floats:
    """Return σ² of each kind of row (in units of the scaled differences), then σ_F², σ_M², none negative.

    Parameters
    ----------
    differences : (c, m).
    levers : (c, m, 6).
    row_kinds : (m,).
    basis : (kinds, c, m, m) what a unit of each kind's variance adds; None: its rows alike and apart.
    """
    m = differences.shape[1]
    own = np.unique(row_kinds)
    if basis is None:
        units = np.stack([np.diag((row_kinds == kind).astype(np.float64)) for kind in own])
        basis = np.broadcast_to(units[:, None], (len(own), len(differences), m, m))
    kinds = list(basis)
    kinds += [
        np.einsum("cak,cbk->cab", levers[:, :, :3], levers[:, :, :3]),
        np.einsum("cak,cbk->cab", levers[:, :, 3:], levers[:, :, 3:]),
    ]
    size = np.array([float(np.mean(np.trace(kind, axis1=1, axis2=2))) / m for kind in kinds])
    # A lever that is rounding instead of zero is none: its variance would be anything.
    least = ROUNDING**2 * max(size, default=0.0)
    active = [i for i in range(len(kinds)) if size[i] > least]
    variance = np.zeros(len(kinds))
    for i in active:
        # Start: the tracker makes most of the scatter, the wrench a little.
        variance[i] = 0.9 if i < len(own) else 0.05 / size[i]
    variance[active] = _most_likely_variances(
        np.stack([kinds[i] for i in active]), differences, variance[active], size[active]
    )
    return variance


def _most_likely_variances(basis: Floats, differences: Floats, start: Floats, size: Floats) -> Floats:
    """Return the variances (q,) of most likelihood, none negative, by Fisher scoring.

    Each step goes to the minimum of the likelihood's quadratic model among variances that are not negative, and is
    halved until the likelihood rises.

    Parameters
    ----------
    basis : (q, c, m, m) what a unit of each variance adds to the contrasts' covariances.
    differences : (c, m) contrasts.
    start : (q,) positive.
    size : (q,) what a unit of each adds on average.

    Raises
    ------
    InputError : the shares still move by more than `SETTLED` after `MOST_STEPS`, while the likelihood rises.
    """
    variance, best = start, _likelihood(basis, differences, start)
    for _ in range(MOST_STEPS):
        inverse = np.linalg.inv(np.tensordot(variance, basis, axes=1))
        projected = np.matmul(inverse, basis)
        weighted = np.matmul(inverse, differences[:, :, None])[:, :, 0]
        pulled = np.matmul(basis, weighted[None, :, :, None])[..., 0]
        score = np.sum(pulled * weighted, axis=(1, 2)) - np.einsum("icaa->i", projected)
        flat = projected.reshape(len(basis), -1)
        information = flat @ np.swapaxes(projected, 2, 3).reshape(len(basis), -1).T
        aim, share = _least_not_negative(information, information @ variance + score), 1.0
        change = float(np.max(np.abs(aim - variance) * size))
        while share > 1e-3:
            trial = variance + share * (aim - variance)
            likelihood = _likelihood(basis, differences, trial)
            if likelihood >= best:
                variance, best = trial, likelihood
                break
            share /= 2.0
        if change < SETTLED or share <= 1e-3:
            return variance
    raise InputError.at(
        FaultCode.NO_CONVERGENCE,
        "campaign.toml", "sources", f"the variance components of the repeats do not converge in {MOST_STEPS} steps",
        "state sigma of the instruments",
    )  # fmt: skip


def _likelihood(basis: Floats, differences: Floats, variance: Floats) -> float:
    """Return twice the log-likelihood but for a constant; −∞ where a covariance is not positive."""
    total = np.tensordot(variance, basis, axes=1)
    sign, logarithm = np.linalg.slogdet(total)
    if not np.all(sign > 0.0):
        return -np.inf
    weighted = np.linalg.solve(total, differences[:, :, None])[:, :, 0]
    return -float(np.sum(logarithm) + np.sum(weighted * differences))


def _least_not_negative(matrix: Floats, vector: Floats) -> Floats:
    """Return the x ≥ 0 that minimises ½ xᵀ M x − vᵀ x: of the few sets of x that can be free, the best."""
    best, least = np.zeros(len(vector)), 0.0
    for chosen in range(1, 1 << len(vector)):
        free = np.array([bool(chosen >> i & 1) for i in range(len(vector))])
        x = np.zeros(len(vector))
        x[free] = np.linalg.lstsq(matrix[np.ix_(free, free)], vector[free], rcond=1e-12)[0]
        value = float(0.5 * x @ matrix @ x - vector @ x)
        if value < least and np.all(x >= 0.0):
            best, least = x, value
    return best
