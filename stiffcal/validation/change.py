"""Has a parameter changed between two fits, and how surely."""

from __future__ import annotations

import math

from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.validation.compare_result import Change, FittedValue

CHANCE = 0.01
"""A change counts where so much or more would come by chance with less than this probability, all parameters together
(Bonferroni)."""


def change_of(before: IdentifiedParameter, after: IdentifiedParameter) -> Change:
    """Return the change of a parameter from one fit to another."""
    change = relative = std = p_value = None
    if before.value is not None and after.value is not None and before.std is not None and after.std is not None:
        change, std = after.value - before.value, math.hypot(_std_of_noise(before), _std_of_noise(after))
        relative = change / before.value if before.value else None
        p_value = math.erfc(abs(change) / std / math.sqrt(2.0)) if std > 0.0 else None
    return Change(
        name=before.name,
        effect=before.effect,
        where=before.where,
        unit=before.unit,
        before=_fitted_value(before),
        after=_fitted_value(after),
        change=change,
        relative=relative,
        std=std,
        p_value=p_value,
    )


def _std_of_noise(parameter: IdentifiedParameter) -> float:
    """Return the standard uncertainty but for the geometry's share: an error of it is the same before and after."""
    return (parameter.std or 0.0) * math.sqrt(max(1.0 - (parameter.from_geometry or 0.0), 0.0))


def _fitted_value(parameter: IdentifiedParameter) -> FittedValue:
    return FittedValue(
        value=parameter.value,
        std=parameter.std,
        stiffness=parameter.stiffness,
        stiffness_std=parameter.stiffness_std,
    )
