"""The share of the avoidable error that a set of effects explains, with its interval over poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.lack_of_fit import LackOfFit
from stiffcal.diagnosis.scans.scan import ROUNDING, Scan
from stiffcal.diagnosis.thresholds import (
    RESAMPLINGS,
)


@dataclass(frozen=True)
class Explained:
    """How much of the avoidable error goes."""

    share: float
    """Of the squares of the error in poses left out, less those of the noise."""
    low: float
    """Lower 95 % limit over poses, the uncertainty of the noise included."""
    high: float
    """Upper 95 % limit."""
    avoidable: float
    """The present model's avoidable squares, in units of the noise's."""


def explained_share(
    first: Scan, last: Scan, before: LackOfFit | None, after: LackOfFit | None, seed: int = 0
) -> Explained:
    """Return the share of the avoidable error that goes from one model to another.

    Parameters
    ----------
    first, last : scans of the model without and with the effects.
    before, after : their residuals against the noise of the last model, which no missing effect has swollen; None
        where the noise is not known: then all of the error counts as avoidable, and each model's errors, which are
        whitened with its own residuals, are made comparable by the sizes of these.
    seed : of the resampling of poses.

    Returns
    -------
    Explained
        Bootstrap percentiles over poses (Efron and Tibshirani 1993, chapter 13); the noise is drawn with them where it
        is estimated from repeats. Where the last model fits all poses to within the noise, what its values' uncertainty
        adds to a prediction is not left for another effect: only the slowest speeds show a Stribeck velocity, and
        without them it is not known. There each pose counts as `predictive_squares`.
    """
    left = (
        np.minimum(last.base.heldout, predictive_squares(last))
        if after is not None and after.fits
        else last.base.heldout
    )
    squares = first.base.heldout / first.dof, left / last.dof
    e_before, e_after = (float(np.sum(square)) for square in squares)
    scale = before.ratio**2 / e_before if before is not None and e_before > 0.0 else _mean_square_ratio(first, last)
    error_after = float(np.sum(last.base.heldout)) / last.dof
    scale_after = after.ratio**2 / error_after if after is not None and error_after > 0.0 else 1.0
    floor = 0.0 if after is None else 1.0 / after.drift**2 if after.drifts else 1.0
    share = _share(e_before * scale, e_after * scale_after, floor)
    rng = np.random.default_rng(seed)
    n_folds = len(first.folds)
    weights = rng.multinomial(n_folds, np.full(n_folds, 1.0 / n_folds), size=RESAMPLINGS)
    known = after.dof[1] if after is not None else np.inf
    floors = floor * (known / rng.chisquare(known, RESAMPLINGS) if np.isfinite(known) else np.ones(RESAMPLINGS))
    drawn = [
        _share(weighted_before * scale, weighted_after * scale_after, bottom)
        for weighted_before, weighted_after, bottom in zip(
            weights @ squares[0], weights @ squares[1], floors, strict=True
        )
    ]
    low, high = np.quantile(drawn, (0.025, 0.975))
    return Explained(share, float(low), float(high), max(e_before * scale - floor, 0.0))


def predictive_squares(scan: Scan) -> Floats:
    """Return (F,) squares of each pose's errors, by the covariance of its noise and of its prediction without it.

    That is by how much the fit's sum of squares grows with the pose: eᵀ (I + X C Xᵀ)⁻¹ e, C the covariance of the
    values fitted without it (Cook and Weisberg, Residuals and Influence in Regression, 1982, section 2.2).
    """
    return np.asarray(np.maximum(scan.base.sum_of_squares - scan.base.left.rest, 0.0))


def _mean_square_ratio(first: Scan, last: Scan) -> float:
    """Return the mean square of one model's residuals over that of another, of the first kind of readings.

    It is 1 where a noise is known, as both are then whitened with it, and where the second model leaves no residual.
    """
    if first.fit.noise is not None or last.fit.noise is not None:
        return 1.0
    first_square, last_square = first.mean_square(), last.mean_square()
    return first_square / last_square if last_square > 0.0 else 1.0


def _share(before: float, after: float, floor: float) -> float:
    avoidable = before - floor
    return float(np.clip((before - after) / avoidable, 0.0, 1.0)) if avoidable > ROUNDING * before else 1.0
