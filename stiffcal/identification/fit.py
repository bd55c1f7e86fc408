"""What a fit found: parameters with uncertainty, residuals, and what the data cannot determine."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stiffcal.arrays import Floats
from stiffcal.identification.geometry_prior import GeometryPrior
from stiffcal.identification.noise import Noise, Whitening
from stiffcal.identification.readings import Observations
from stiffcal.identification.undetermined import Undetermined
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole, ParameterSpec, Place
from stiffcal.uncertainty import is_poorly_known

# Of 36 compliances that are nothing one rises above this many standard uncertainties in one campaign of twenty.
ABOVE_NOISE = 3.0


@dataclass(frozen=True)
class Stiffness:
    """One over a compliance, N·m/rad or N/m; NaN where it is not known, or the compliance is 0."""

    value: float = math.nan
    std: float = math.nan
    """Standard uncertainty."""
    interval: list[float | None] | None = None
    """Both ends of the 95 % interval; None where there is no end, or no interval is known."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a fit."""

    name: str
    """Full name, ``effect.place.symbol``."""
    effect: str
    """The effect's name."""
    place: Place
    """Where it acts."""
    spec: ParameterSpec
    """Symbol, unit, bounds."""
    value: float | None
    """Estimate, None where not identifiable."""
    std: float | None
    """Standard uncertainty, None where fixed or not identifiable."""
    interval: tuple[float, float] | None
    """95 %, clipped to possible values; None where fixed or not identifiable."""
    fixed: bool
    """Held at the model file's value."""
    identifiable: bool
    """Whether these data distinguish it from the others."""
    at_bound: bool
    """The estimate lies on the edge of possible values."""
    from_geometry: float | None = None
    """Share of the variance that the geometry's tolerance makes, 0 to 1; None where no uncertainty is known."""

    @property
    def poorly_known(self) -> bool:
        """True where the value is known, but hardly. What may have either sign may well be zero and is not meant."""
        if self.value is None or self.std is None or self.spec.lower < 0.0:
            return False
        return is_poorly_known(self.value, self.std)

    @property
    def above_noise(self) -> bool | None:
        """Whether a size differs from zero at three standard uncertainties; None where it is not free."""
        if self.value is None or self.std is None or self.spec.role is not ParameterRole.AMPLITUDE or self.spec.inverse:
            return None
        return bool(abs(self.value) > ABOVE_NOISE * self.std)

    def stiffness(self) -> Stiffness | None:
        """Return the stiffness of a compliance; None of other parameters."""
        if not self.spec.compliance:
            return None
        if self.value is None:
            return Stiffness()
        value = 1.0 / self.value if self.value > 0.0 else math.nan
        std = math.nan if self.std is None else self.std * value**2
        if self.interval is None:
            return Stiffness(value, std)
        low, high = self.interval
        return Stiffness(value, std, [1.0 / high if high > 0.0 else None, 1.0 / low if low > 0.0 else None])


@dataclass(frozen=True)
class Ambiguity:
    """Parameters that these data cannot distinguish from each other, and what of them is known."""

    names: tuple[str, ...]
    """The parameters."""
    known: str
    """The combination that is known, in words; "" where nothing is."""
    cause: Undetermined
    """Why."""
    coefficients: tuple[float, ...] = ()
    """Of the known combination, one per name; empty where nothing is known."""
    value: float | None = None
    """The value of the known combination; None where there is none."""
    std: float | None = None
    """Its standard uncertainty; None where there is none."""


@dataclass(frozen=True)
class Fit:
    """The result of an identification."""

    robot: CompliantRobot
    """The model with the estimated values (parameters that are not identifiable at their neutral value)."""
    parameters: tuple[Parameter, ...]
    """All of them, in the model's order."""
    covariance: Floats
    """(p, p) of the free, identifiable amplitudes, in the order of ``free_names``."""
    free_names: tuple[str, ...]
    """p full names."""
    condition: float
    """Condition number of the whitened observation matrix with columns of unit length."""
    ambiguities: tuple[Ambiguity, ...]
    """Sets of parameters that cannot be distinguished."""
    noise: Noise | None
    """Instrument noise, or None where it cannot be determined."""
    noise_length: dict[str, float | None]
    """{"translation", "rotation"}, with rods "length": rms length of the noise, wrench noise included; None where not
    known.
    """
    scaled: bool
    """True where standard uncertainties were scaled by the reduced χ², the noise not being known."""
    reduced_chi2: float | None
    """Weighted sum of squares over degrees of freedom; None where the noise is not known."""
    dof: int
    """Degrees of freedom of the fit."""
    residual: Floats
    """(m, n) measured minus predicted, each run's offset taken out, base axes."""
    predicted: Floats
    """(m, n) model's displacement plus the run's offset."""
    data: Observations
    """The observations that were fitted."""
    iterations: int
    """Gauss–Newton steps taken."""
    left_at_neutral: frozenset[str] = frozenset()
    """Full names of parameters left at their neutral value because nothing distinguishes them."""
    whitening: Whitening | None = None
    """Weights of ``data`` in the last step."""
    geometry: GeometryPrior | None = None
    """How well the geometry is known, where ``covariance`` holds what it makes; None where it counts as exact."""
    covariance_from_geometry: Floats | None = None
    """(p, p) the part of ``covariance`` that the geometry's tolerance makes."""
    last_step: float | None = None
    """The last step, in standard uncertainties per parameter, where the fit did not settle; None where it did."""

    def parameter(self, name: str) -> Parameter:
        """Return a parameter by its full name; KeyError where there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)
