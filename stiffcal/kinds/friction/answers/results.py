"""What ``identify`` answers of friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.document_arrays import Matrix, Vector
from stiffcal.documents import KeyIf, Number, OrAbsent
from stiffcal.measurements.rms import VarianceRatio


@dataclass(frozen=True, slots=True, kw_only=True)
class BetweenDirections:
    """What both directions share: weight, the torque's zero, friction that differs by direction."""

    mean: float
    """Over the speeds, N·m."""
    low: float
    """N·m."""
    high: float
    """N·m."""
    weight_possible: bool
    """Whether the joint's axis can carry weight."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedCurve:
    """Friction over speed."""

    velocity: Vector
    """(n,) rad/s, rising."""
    torque: Vector
    """(n,) N·m."""
    std: Vector
    """(n,) N·m, standard uncertainty of `torque`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SymbolCovariance:
    """Covariance of the estimated parameters."""

    symbols: list[str]
    """Full names of the parameters."""
    matrix: Matrix
    """Square, in the order of `symbols`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointFrictionResult:
    """One joint: how it was measured, and what the law leaves."""

    joint: int
    """From 1."""
    name: str
    """The joint's."""
    method: Literal["steady velocities", "weight and inertia modelled"]
    """From stretches of steady velocity, or from the whole motion."""
    n_readings: int
    """Readings that were used."""
    n_speeds: int | None
    """Null where no velocity was constant."""
    lowest_speed: float
    """rad/s."""
    highest_speed: float
    """rad/s."""
    rms: float
    """Of what the law leaves, N·m."""
    noise: Number
    """Of the means over bins, from the scatter of neighbouring samples, N·m; null where these do not show it."""
    reference_temperature: OrAbsent[float] = None
    """K, the first that was logged: effects of temperature count from there; absent where none was logged."""
    between_directions: BetweenDirections | None
    curve: FittedCurve
    covariance: SymbolCovariance


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingFriction:
    """Friction of a joint's own bearing where the drive's shaft turns with several joints."""

    joint: int
    """From 1."""
    coulomb: float
    """N·m."""
    coulomb_std: float
    """N·m."""
    viscous: float
    """N·m·s/rad."""
    viscous_std: float
    """N·m·s/rad."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionSection:
    """Friction of the drives."""

    effects: OrAbsent[list[str]] = None
    """The laws that friction runs identify."""
    joints: list[JointFrictionResult]
    lack_of_fit: Annotated[VarianceRatio | None, KeyIf("is_fitted")] = None
    """Null where repeats are too few."""
    bearings: OrAbsent[list[BearingFriction]] = None

    @property
    def is_fitted(self) -> bool:
        """Whether the model holds friction that these runs could be fitted with."""
        return self.effects is not None
