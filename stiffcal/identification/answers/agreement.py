"""Whether kinds of experiment that determine the same parameters agree on them.

Each kind's states are fitted alone with the same model. Their noise is independent, so that the differences d of the
estimates of common parameters have the covariance C₁ + C₂, and dᵀ (C₁ + C₂)⁻¹ d is χ² with as many degrees of freedom
as there are common parameters where model and instruments are right (ISO 13528:2022, E_n numbers, for several
quantities).
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from stiffcal.arrays import Booleans
from stiffcal.errors import InputError
from stiffcal.estimation.parameters import Parameter
from stiffcal.identification.answers.agreement_results import Agreement, CommonParameter
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import with_geometry
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.fitting.not_fitted import is_not_fitted
from stiffcal.identification.readings.state_kinds import kinds_of_states
from stiffcal.measurements.load_states import LoadStates

LEAST_P = 1e-3
"""Experiments whose differences are less probable than this disagree."""


def agreement_of_experiments(states: LoadStates, fit: Fit, settings: Settings) -> list[Agreement]:
    """Compare what each kind of experiment determines alone; empty where there is only one, or nothing in common.

    Parameters
    ----------
    states : all states of the campaign.
    fit : of all of them together, where each fit begins.
    settings : how it was made.
    """
    kinds = [(kind, mask) for kind, mask in kinds_of_states(states) if np.any(mask & states.used)]
    if len(kinds) < 2:
        return []
    fits = {kind.name: _fit_alone(states, mask, fit, settings) for kind, mask in kinds}
    pairs = [
        _agreement((first, one), (second, other))
        for (first, one), (second, other) in combinations(fits.items(), 2)
        if one is not None and other is not None
    ]
    return [pair for pair in pairs if pair is not None]


def _fit_alone(states: LoadStates, mask: Booleans, fit: Fit, settings: Settings) -> Fit | None:
    """Return the fit of some states; None where they do not determine any of the model's parameters."""
    try:
        # of these states alone, so that their noise is known from where it is when nothing else is measured
        own = states.select(mask)
        return with_geometry(identify_parameters(own, fit.robot, settings), own)
    except InputError as error:
        if not is_not_fitted(error):
            raise
        return None


def _agreement(first: tuple[str, Fit], second: tuple[str, Fit]) -> Agreement | None:
    from scipy.special import chdtrc

    (kind, fit), (other_kind, other) = first, second
    names = [
        name for name in fit.free_names if name in other.free_names and _is_known(fit, name) and _is_known(other, name)
    ]
    if not names:
        return None
    rows = [fit.free_names.index(name) for name in names]
    columns = [other.free_names.index(name) for name in names]
    covariance = fit.covariance[np.ix_(rows, rows)] + other.covariance[np.ix_(columns, columns)]
    difference = np.array([_amplitude(other.parameter(name)) - _amplitude(fit.parameter(name)) for name in names])
    scale = np.sqrt(np.diag(covariance))
    statistic = float(difference / scale @ np.linalg.solve(covariance / np.outer(scale, scale), difference / scale))
    p_value = float(chdtrc(len(names), statistic))
    parameters = []
    for name, away in zip(names, difference / scale, strict=True):
        own, others = fit.parameter(name), other.parameter(name)
        parameters.append(
            CommonParameter(
                name=name,
                unit=own.spec.unit,
                first=float(own.value or 0.0),
                first_std=float(own.std or 0.0),
                second=float(others.value or 0.0),
                second_std=float(others.std or 0.0),
                standard_errors=float(-away if own.spec.inverse else away),
            )
        )
    return Agreement(
        first=kind,
        second=other_kind,
        parameters=parameters,
        statistic=statistic,
        dof=len(names),
        p_value=p_value,
        agree=p_value >= LEAST_P,
        reduced_chi2=[fit.reduced_chi2, other.reduced_chi2],
    )


def _is_known(fit: Fit, name: str) -> bool:
    parameter = fit.parameter(name)
    return parameter.value is not None and bool(parameter.std) and not parameter.at_bound


def _amplitude(parameter: Parameter) -> float:
    """Return what the covariance is of: one over the value of stiffness-like parameters."""
    value = float(parameter.value or 0.0)
    return 1.0 / value if parameter.spec.inverse else value
