"""What a fit gives for each parameter: value, standard uncertainty, interval; or that the data do not determine it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffcal.estimate import Estimate
from stiffcal.estimation.unknowns import amplitude_bounds
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import ParameterRole, ParameterSpec, Place
from stiffcal.uncertainty import NORMAL_95, is_poorly_known

# Of 36 compliances that are nothing one rises above this many standard uncertainties in one campaign of twenty.
ABOVE_NOISE = 3.0
# Above them four terms of the expansion are exact to twelve digits.
MANY_DEGREES = 1000
# Every parameter may go as far as is possible.
NOWHERE_NEARER: Mapping[str, tuple[float, float]] = {}


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
    """Standard uncertainty, None where fixed, not identifiable, or on a bound."""
    interval: tuple[float, float] | None
    """95 %, as `interval_within`; None where fixed or not identifiable."""
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
        """Whether a size differs from zero at three standard uncertainties; None where held or on a bound."""
        if self.value is None or self.fixed or self.spec.role is not ParameterRole.AMPLITUDE or self.spec.inverse:
            return None
        if self.std is None:
            return False if self.at_bound and not self.value else None
        return bool(abs(self.value) > ABOVE_NOISE * self.std)

    def stiffness(self) -> Estimate | None:
        """Return the stiffness of a compliance; None of other parameters."""
        if not self.spec.compliance:
            return None
        interval: list[float | None] | None = None if self.interval is None else [*self.interval]
        return Estimate(value=self.value, std=self.std, interval=interval).reciprocal()


def student_95(dof: int) -> float:
    """Return the two-sided 95 % quantile of Student's t."""
    if dof > MANY_DEGREES:
        z = NORMAL_95  # Abramowitz and Stegun 26.7.5
        first = (z**3 + z) / 4.0
        second = (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
        third = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
        return z + (first + (second + third / dof) / dof) / dof
    from scipy.special import stdtrit  # takes a tenth of a second to load, as long as a check of 200 runs

    return float(stdtrit(dof, 0.975)) if dof > 0 else np.inf


def reported_parameters(
    robot: CompliantRobot,
    spread: Mapping[str, float],
    quantile: float,
    fixed: frozenset[str],
    reach: Mapping[str, tuple[float, float]] = NOWHERE_NEARER,
) -> list[Parameter]:
    """Turn amplitudes into reported parameters, with intervals kept within what is possible.

    Parameters
    ----------
    robot : with values.
    spread : full name to standard uncertainty of the amplitude, for those that were determined.
    quantile : half width of the interval in standard uncertainties.
    fixed : full names that kept their values.
    reach : full name to the ends of where the fit looked, of amplitudes that the data bound within what is possible.
    """
    parameters = []
    for placed_effect in robot.placed:
        for spec in placed_effect.effect.parameters:
            name = placed_effect.parameter_name(spec.symbol)
            if name in fixed:
                value = placed_effect.values.get(spec.symbol, spec.neutral)
                parameters.append(
                    Parameter(
                        name, placed_effect.effect.name, placed_effect.place, spec, value, None, None, True, True, False
                    )
                )
                continue
            if spec.discrete:
                value = placed_effect.values.get(spec.symbol, spec.typical)
                parameters.append(
                    Parameter(
                        name,
                        placed_effect.effect.name,
                        placed_effect.place,
                        spec,
                        value,
                        None,
                        None,
                        False,
                        True,
                        False,
                    )
                )
                continue
            if name not in spread:
                parameters.append(
                    Parameter(
                        name,
                        placed_effect.effect.name,
                        placed_effect.place,
                        spec,
                        None,
                        None,
                        None,
                        False,
                        False,
                        False,
                    )
                )
                continue
            parameters.append(
                estimated_parameter(
                    name,
                    placed_effect.effect.name,
                    placed_effect.place,
                    spec,
                    placed_effect.amplitude(spec.symbol),
                    spread[name],
                    quantile,
                    reach.get(name, amplitude_bounds(spec)),
                )
            )
    return parameters


def interval_within(
    spec: ParameterSpec, amplitude: float, half: float, bounds: tuple[float, float]
) -> tuple[float, float]:
    """Return both ends of a parameter's interval, kept within its bounds; infinite where one is open.

    What lies on a bound of its range would go further without it: that end is open. An amplitude of 0 is no such bound,
    but the absence of the effect.

    Parameters
    ----------
    amplitude : the estimate, as the fit counts it (of an inverse parameter one over the value). half : of its interval.
    bounds : of the amplitude in the fit.
    """
    low, high = bounds
    on_low, on_high = on_bounds(amplitude, half, bounds)
    first = -math.inf if on_low and low != 0.0 else max(low, amplitude - half)
    last = math.inf if on_high and high != 0.0 else min(high, amplitude + half)
    if spec.inverse:
        return 1.0 / last, 1.0 / first if first > 0.0 else math.inf
    return first + spec.neutral, last + spec.neutral


def on_bounds(amplitude: float, half: float, bounds: tuple[float, float]) -> tuple[bool, bool]:
    """Return whether an estimate lies on its lower and on its upper bound; arguments as of `interval_within`."""
    low, high = bounds
    tiny = 1e-9 * max(half, 1e-300)
    return bool(amplitude <= low + tiny), bool(amplitude >= high - tiny)


def estimated_parameter(
    name: str,
    effect: str,
    place: Place,
    spec: ParameterSpec,
    amplitude: float,
    std: float,
    quantile: float,
    bounds: tuple[float, float],
) -> Parameter:
    """Return a parameter that was estimated; on a bound of its range it has no standard uncertainty.

    Parameters
    ----------
    name, effect, place, spec : as of `Parameter`.
    amplitude, std : the estimate and its standard uncertainty, as the fit counts it.
    quantile : half width of the interval in standard uncertainties.
    bounds : of the amplitude in the fit.
    """
    at_bound = any(on_bounds(amplitude, std, bounds))
    value = spec.value_of(amplitude)
    # beyond the bound that holds it nothing is known of the estimate's distribution
    spread = None if at_bound else std * value**2 if spec.inverse else std
    interval = interval_within(spec, amplitude, quantile * std, bounds)
    return Parameter(name, effect, place, spec, value, spread, interval, False, True, at_bound)
