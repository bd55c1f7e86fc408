"""Distances between predicted and measured places, as answers state them."""

from __future__ import annotations

from dataclasses import dataclass, field

from stiffcal.documents import Number, OrAbsent


@dataclass(frozen=True, slots=True)
class TargetDistance:
    """Distances between predicted and measured places of one target, m."""

    target: str
    """Its frame's name."""
    mean: float
    """m."""
    median: float
    """m."""
    p95: float
    """95 % of the places are nearer."""
    max: float
    """m."""
    rms: float
    """Root mean square, m."""
    n: int
    """Places."""


@dataclass(frozen=True, slots=True)
class DistanceSummary:
    """Distances between predicted and measured places of all targets, m."""

    mean: float
    """m."""
    median: float
    """m."""
    p95: float
    """95 % of the places are nearer."""
    max: float
    """m."""
    rms: float
    """Root mean square, m."""
    n: int
    """Places."""
    by_target: list[TargetDistance]
    """Of each target by itself."""


@dataclass(frozen=True, slots=True)
class RegionDistance:
    """Distances in one region of the joints' ranges, predicted by a fit without it, m."""

    region: int
    """From 1, as the regions are left out."""
    mean: float
    """m."""
    median: float
    """m."""
    p95: float
    """95 % of the places are nearer."""
    max: float
    """m."""
    rms: float
    """Root mean square, m."""
    n: int
    """Places."""
    centre: list[float] = field(default_factory=list)
    """Mean direction of each logged joint angle over its rows, rad, −π to π; of a prismatic joint its mean, m."""


@dataclass(frozen=True, slots=True)
class NoiseDistance:
    """Distances that the instruments' noise alone makes of a right model, m.

    Of three axes with the same standard uncertainty σ the distance has Maxwell's distribution: mean √(8/π) σ = 1.596 σ,
    median 1.538 σ, 95 % 2.795 σ, rms √3 σ (Johnson, Kotz and Balakrishnan, Continuous Univariate Distributions 1,
    1994, chapter 18).
    """

    mean: float
    """m."""
    median: float
    """m."""
    p95: float
    """95 % of the distances are smaller, m."""
    rms: float
    """Root mean square, m: √3 times the standard uncertainty of one axis."""

    @classmethod
    def of_rms(cls, rms: float) -> NoiseDistance:
        """Return the distances of noise with this rms length.

        Examples
        --------
        >>> round(NoiseDistance.of_rms(3.0**0.5).mean, 3)
        1.596
        """
        sigma = rms / 3.0**0.5
        return cls(mean=1.595769 * sigma, median=1.538172 * sigma, p95=2.795483 * sigma, rms=rms)


@dataclass(frozen=True, slots=True)
class Distances:
    """Distances in the rows that were fitted, and in rows that were left out of the fit."""

    fit: DistanceSummary
    """Of the fit."""
    heldout_random: DistanceSummary | None
    """A sixth of the poses at a time left out, drawn at random; None of a single pose."""
    heldout_region: DistanceSummary | None
    """One of six regions of the joints' ranges at a time left out; None of a single pose."""
    by_region: list[RegionDistance] = field(default_factory=list)
    """Of each region that was left out."""
    noise: OrAbsent[NoiseDistance] = None
    """What the noise alone makes, the same on all three axes; None where it is not known."""


@dataclass(frozen=True, slots=True)
class LadderStep:
    """A model of the ladder from the nominal robot to the present model, fitted to the same rows."""

    step: str
    """"nominal", "frames", "offsets", "geometry", "springs" or "model"."""
    n_parameters: int
    """Numbers that were estimated."""
    fit: Number
    """rms distance in the rows that were fitted, m."""
    heldout_random: Number
    """rms distance, a sixth of the poses at a time left out, m."""
    heldout_region: Number
    """rms distance, one of six regions at a time left out, m."""
    mean_region: OrAbsent[Number] = None
    """Mean distance, one of six regions at a time left out, m."""
    mean_random: OrAbsent[Number] = None
    """Mean distance, a sixth of the poses at a time left out, m."""
