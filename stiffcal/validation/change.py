"""Has a parameter changed between two fits, and how surely."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from stiffcal.model.summary import Where
from stiffcal.validation.compare_result import Change, FittedValue

CHANCE = 0.01
"""A change counts where so much or more would come by chance with less than this probability, all parameters together
(Bonferroni)."""


def change_of(before: Mapping[str, Any], after: Mapping[str, Any]) -> Change:
    """Return how a parameter has changed from one fit to another.

    Parameters
    ----------
    before, after : the parameter as in the `identify` documents.
    """
    change = relative = std = p_value = None
    if None not in (before["value"], after["value"], before["std"], after["std"]):
        change, std = after["value"] - before["value"], math.hypot(before["std"], after["std"])
        relative = change / before["value"] if before["value"] else None
        p_value = math.erfc(abs(change) / std / math.sqrt(2.0)) if std > 0.0 else None
    return Change(
        name=before["name"],
        effect=before["effect"],
        where=Where(**before["where"]),
        unit=before["unit"],
        before=_fitted_value(before),
        after=_fitted_value(after),
        change=change,
        relative=relative,
        std=std,
        p_value=p_value,
    )


def _fitted_value(parameter: Mapping[str, Any]) -> FittedValue:
    if "stiffness" not in parameter:
        return FittedValue(value=parameter["value"], std=parameter["std"])
    found = (parameter.get(key) for key in ("stiffness", "stiffness_std"))
    stiffness, std = (math.nan if value is None else value for value in found)
    return FittedValue(value=parameter["value"], std=parameter["std"], stiffness=stiffness, stiffness_std=std)
