"""What a fit gives for each parameter: value, standard uncertainty, interval; or that the data do not determine it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fit import Parameter
from stiffcal.identification.observation import ParameterColumn
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import ParameterSpec, Place


def amplitude_bounds(spec: ParameterSpec) -> tuple[float, float]:
    """Return the bounds of what the law multiplies with."""
    if spec.inverse:
        return (1.0 / spec.upper if np.isfinite(spec.upper) else 0.0), (
            1.0 / spec.lower if spec.lower > 0.0 else np.inf
        )
    return spec.lower - spec.neutral, spec.upper - spec.neutral


def amplitudes(robot: CompliantRobot, columns: Sequence[ParameterColumn]) -> Floats:
    """Return the free parameters' present values, as the fit counts them."""
    return np.array([robot.placed[c.placed].amplitude(c.symbol) for c in columns], dtype=np.float64)


def bounds_of(robot: CompliantRobot, columns: Sequence[ParameterColumn]) -> tuple[Floats, Floats]:
    """Return lower and upper bounds of the amplitudes."""
    lower, upper = [], []
    for column in columns:
        low, high = amplitude_bounds(robot.placed[column.placed].effect.spec(column.symbol))
        lower.append(low)
        upper.append(high)
    return np.array(lower), np.array(upper)


def student_95(dof: int) -> float:
    """Return the two-sided 95 % quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(dof, 0.975)) if dof > 0 else np.inf


def reported_parameters(
    robot: CompliantRobot, spread: Mapping[str, float], quantile: float, fixed: frozenset[str]
) -> list[Parameter]:
    """Turn amplitudes into reported parameters, with intervals kept within what is possible.

    Parameters
    ----------
    robot : with values.
    spread : full name to standard uncertainty of the amplitude, for those that were determined.
    quantile : half width of the interval in standard uncertainties.
    fixed : full names that kept their values.
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
                _estimated(
                    name,
                    placed_effect.effect.name,
                    placed_effect.place,
                    spec,
                    placed_effect.amplitude(spec.symbol),
                    spread[name],
                    quantile,
                )
            )
    return parameters


def _estimated(
    name: str, effect: str, place: Place, spec: ParameterSpec, amplitude: float, std: float, quantile: float
) -> Parameter:
    low, high = amplitude_bounds(spec)
    tiny = 1e-9 * max(std, 1e-300)
    at_bound = bool(amplitude <= low + tiny or amplitude >= high - tiny)
    interval = (max(low, amplitude - quantile * std), min(high, amplitude + quantile * std))
    value = spec.value_of(amplitude)
    if not spec.inverse:
        shifted = (interval[0] + spec.neutral, interval[1] + spec.neutral)
        return Parameter(name, effect, place, spec, value, std, shifted, False, True, at_bound)
    bounds = (1.0 / interval[1], 1.0 / interval[0] if interval[0] > 0.0 else np.inf)
    return Parameter(name, effect, place, spec, value, std * value**2, bounds, False, True, at_bound)
