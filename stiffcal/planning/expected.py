"""How well parameters would be known: the noise of the readings, and what the geometry's tolerance adds.

Errors of the robot file's lengths and angles are common to all runs. With small errors g the fit answers with other
compliances, B g (`identification.fitting.geometry`); with a prior of g their covariance grows by B Σ Bᵀ, which more
runs of one kind do not reduce.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.planning.design import VAGUE


@dataclass(frozen=True)
class ExpectedFit:
    """What the first 1 … n runs of a plan bring on p parameters."""

    covariance: Floats
    """(p, p) after all runs, relative to the parameters' values."""
    course: Floats
    """(n, p) standard uncertainty after the first 1 … n runs, likewise."""
    from_geometry: Floats
    """(p,) share of the geometry's tolerance in the variances after all runs."""
    without: Floats
    """(n, p) standard uncertainty where one run is lost, all others measured."""


def expected_fit(factors: Floats, geometry: Floats, sizes: Floats, known: Floats | None) -> ExpectedFit:
    """Return what runs bring.

    Parameters
    ----------
    factors : (n, r, p) of the runs in order of rank, relative to the parameters' values.
    geometry : (n, r, g) what errors of the geometry do to the same readings.
    sizes : (g,) standard deviations of the geometry.
    known : (p, p) information that there is already, relative to the values; None: none.
    """
    p = factors.shape[2]
    start = np.eye(p) / VAGUE**2 if known is None else known + np.eye(p) / VAGUE**2
    transposed = np.swapaxes(factors, 1, 2)
    matrices, slopes = transposed @ factors, transposed @ (geometry * sizes)
    whole, slope = start + matrices.sum(axis=0), slopes.sum(axis=0)
    covariance, noise_alone = _covariance(whole[None], slope[None])
    course, _ = _covariance(start + np.cumsum(matrices, axis=0), np.cumsum(slopes, axis=0))
    without, _ = _covariance(whole - matrices, slope - slopes)
    variance = np.diagonal(covariance[0])
    return ExpectedFit(
        covariance[0], _deviations(course), 1.0 - np.diagonal(noise_alone[0]) / variance, _deviations(without)
    )


def _covariance(matrices: Floats, slopes: Floats) -> tuple[Floats, Floats]:
    """Return (n, p, p) covariances with the geometry, and without."""
    noise_alone: Floats = np.asarray(np.linalg.inv(matrices), dtype=np.float64)
    moved = noise_alone @ slopes
    return noise_alone + moved @ np.swapaxes(moved, 1, 2), noise_alone


def _deviations(covariances: Floats) -> Floats:
    return np.asarray(np.sqrt(np.diagonal(covariances, axis1=1, axis2=2)))
