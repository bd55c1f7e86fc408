"""What a fit found: parameters with uncertainty, residuals, and what the data cannot tell."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stiffcal.arrays import Floats
from stiffcal.identification.noise import Noise
from stiffcal.identification.readings import Observations
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
    """One parameter of a fit.

    Attributes
    ----------
    name : full name, ``effect.place.symbol``.
    effect : the effect's name.
    place : where it acts.
    spec : symbol, unit, bounds.
    value : estimate, None where not identifiable.
    std : standard uncertainty, None where fixed or not identifiable.
    interval : 95 %, clipped to possible values; None where fixed or not identifiable.
    fixed : held at the model file's value.
    identifiable : whether these data can tell it apart.
    at_bound : the estimate lies on the edge of possible values.
    """

    name: str
    effect: str
    place: Place
    spec: ParameterSpec
    value: float | None
    std: float | None
    interval: tuple[float, float] | None
    fixed: bool
    identifiable: bool
    at_bound: bool

    @property
    def poorly_known(self) -> bool:
        """True where the value is known, but hardly. What may have either sign may well be zero and is not meant."""
        if self.value is None or self.std is None or self.spec.lower < 0.0:
            return False
        return is_poorly_known(self.value, self.std)

    @property
    def above_noise(self) -> bool | None:
        """Whether a size is told from none at all, at three standard uncertainties; None where it is not free."""
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
    """Parameters that these data cannot tell apart, and what of them is known.

    Attributes
    ----------
    names : the parameters.
    known : the combination that is known, in words; "" where nothing is.
    reason : why, in words.
    coefficients : of the known combination, one per name; empty where nothing is known.
    value, std : of that combination, or None.
    """

    names: tuple[str, ...]
    known: str
    reason: str
    coefficients: tuple[float, ...] = ()
    value: float | None = None
    std: float | None = None


@dataclass(frozen=True)
class Fit:
    """The result of an identification.

    Attributes
    ----------
    robot : the model with the estimated values (parameters that are not identifiable at their neutral value).
    parameters : all of them, in the model's order.
    covariance : (p, p) of the free, identifiable amplitudes, in the order of ``free_names``.
    free_names : p full names.
    condition : condition number of the whitened observation matrix with columns of unit length.
    ambiguities : what cannot be told apart.
    noise : instrument noise, or None where it cannot be told.
    noise_length : {"translation", "rotation"}, with rods "length": rms length of the noise, wrench noise included; None
        where not known.
    scaled : True where standard uncertainties were scaled by the reduced χ², the noise not being known.
    reduced_chi2 : weighted sum of squares over degrees of freedom; None where the noise is not known.
    dof : degrees of freedom of the fit.
    residual : (m, n) measured minus predicted, each run's offset taken out, base axes.
    predicted : (m, n) model's displacement plus the run's offset.
    data : the observations that were fitted.
    iterations : Gauss–Newton steps taken.
    held : full names of parameters left at their neutral value because nothing tells them apart.
    left : the last step, in standard uncertainties per parameter, where the fit did not settle; None where it did.
    """

    robot: CompliantRobot
    parameters: tuple[Parameter, ...]
    covariance: Floats
    free_names: tuple[str, ...]
    condition: float
    ambiguities: tuple[Ambiguity, ...]
    noise: Noise | None
    noise_length: dict[str, float | None]
    scaled: bool
    reduced_chi2: float | None
    dof: int
    residual: Floats
    predicted: Floats
    data: Observations
    iterations: int
    held: frozenset[str] = frozenset()
    left: float | None = None

    def parameter(self, name: str) -> Parameter:
        """Return a parameter by its full name; KeyError where there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)
