"""How far the model's places are from the measured ones, as people state it of measured robots."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.noise.reading_noise import rms_length
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import TRANSLATION
from stiffcal.mechanics.chain import Chain
from stiffcal.validation.distance_results import (
    Distances,
    DistanceSummary,
    NoiseDistance,
    RegionDistance,
    TargetDistance,
)
from stiffcal.validation.heldout import joined_folds, left_out_residuals
from stiffcal.validation.region_folds import random_folds, region_folds
from stiffcal.validation.schemes import BY_REGION


def distances_of(fit: Fit) -> Distances | None:
    """Return the distances of a fit to absolute poses; None where no place was measured."""
    if not fit.data.absolute.any() or summary_of(fit.residual, fit.data) is None:
        return None
    heldout: list[DistanceSummary | None] = []
    regions: list[RegionDistance] = []
    for folds_of_places in (random_folds, region_folds):
        fold = _folds(fit.data, folds_of_places)
        single = len(np.unique(fold[fit.data.absolute])) == 1
        residual = np.zeros(0) if single else left_out_residuals(fit, fold).residual
        heldout.append(None if single else summary_of(residual, fit.data))
        if folds_of_places is region_folds and not single:
            regions = list(_by_region(residual, fit, fold))
    of_fit = summary_of(fit.residual, fit.data)
    return None if of_fit is None else Distances(of_fit, heldout[0], heldout[1], regions, _noise_of(fit))


def _folds(data: Observations, folds_of_places: Callable[[Observations], Integers]) -> Integers:
    """Return (n,) fold numbers of all states, of places as ``folds_of_places`` has them."""
    return joined_folds(data, lambda kind: folds_of_places if kind.scheme == BY_REGION else kind.folds)


def _noise_of(fit: Fit) -> NoiseDistance | None:
    if fit.noise is None:
        return None
    rms = rms_length(fit.noise, fit.data.subset(fit.data.absolute), None)["translation"]
    return None if rms is None else NoiseDistance.of_rms(rms)


def _by_region(residual: Floats, fit: Fit, fold: Integers) -> Iterator[RegionDistance]:
    data = fit.data
    for region, number in enumerate(np.unique(fold[data.absolute]), start=1):
        members = np.flatnonzero((fold == number) & data.absolute)
        summary = summary_of(residual[:, members], data.subset(members))
        if summary is not None:
            yield RegionDistance(
                region, summary.mean, summary.median, summary.p95, summary.max, summary.rms, summary.n,
                _middle(fit.robot.chain, data.angles[:, members]),
            )  # fmt: skip


def _middle(chain: Chain, angles: Floats) -> list[float]:
    """Return the mean direction of each joint's model angle (J, n), as logged angles from −π to π; m where prismatic.

    Mardia and Jupp, Directional Statistics, 2000, eq. 2.2.4.
    """
    direction = np.arctan2(np.sin(angles).mean(axis=1), np.cos(angles).mean(axis=1))
    middle = np.where(chain.prismatic, angles.mean(axis=1), direction)
    logged = np.linalg.lstsq(chain.coupling, middle - chain.offset, rcond=None)[0]
    around = np.arctan2(np.sin(logged), np.cos(logged))
    return [float(middle) for middle in np.where(chain.prismatic, logged, around)]


def summary_of(residual: Floats, data: Observations) -> DistanceSummary | None:
    """Return the distances that residuals (m, n) are; None where no place was measured."""
    of_targets, every = [], []
    for b, name in enumerate(data.setup.target_names):
        length = _lengths(residual, data, b)
        if len(length):
            of_targets.append(TargetDistance(name, *_figures(length), len(length)))
            every.append(length)
    if not every:
        return None
    together = np.concatenate(every)
    return DistanceSummary(*_figures(together), len(together), of_targets)


def squared_distances(residual: Floats, data: Observations) -> Floats:
    """Return (n,) the squared distances that residuals (m, n) are, of all targets of a row together, m²."""
    rows = (data.kind == TRANSLATION)[:, None] & data.measured_mask
    return np.asarray(np.sum(np.where(rows, residual, 0.0) ** 2, axis=0))


def _lengths(residual: Floats, data: Observations, target: int) -> Floats:
    """Return the distances of one target in the rows in which it was measured in all three components, m."""
    rows = np.flatnonzero((data.kind == TRANSLATION) & (data.body == target))
    if len(rows) < 3:
        return np.zeros(0)
    measured = data.measured_mask[rows].all(axis=0) & data.absolute
    return np.asarray(np.linalg.norm(residual[np.ix_(rows, np.flatnonzero(measured))], axis=0))


def _figures(length: Floats) -> tuple[float, float, float, float, float]:
    return (
        float(length.mean()),
        float(np.median(length)),
        float(np.quantile(length, 0.95)),
        float(length.max()),
        float(np.sqrt(np.mean(length**2))),
    )
