"""Has a parameter changed between two fits, and how surely."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

CHANCE = 0.01
"""A change counts where so much or more would come by chance with less than this probability, all parameters together
(Bonferroni)."""


def change_of(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """Return how a parameter has changed from one fit to another.

    Parameters
    ----------
    one, other : the parameter as in the `identify` documents, before and after.

    Returns
    -------
    dict
        ``before`` and ``after`` with value and standard uncertainty (of a compliance also as stiffness), ``change``,
        ``relative``, its standard uncertainty ``std``, ``p_value``: two-sided, normal; null where a value or its
        uncertainty is not known.
    """
    row: dict[str, Any] = {
        "name": one["name"],
        "effect": one["effect"],
        "where": one["where"],
        "unit": one["unit"],
        "before": {"value": one["value"], "std": one["std"]},
        "after": {"value": other["value"], "std": other["std"]},
        "change": None,
        "relative": None,
        "std": None,
        "p_value": None,
    }
    for key, document in (("before", one), ("after", other)):
        if "stiffness" in document:
            row[key] |= {"stiffness": document["stiffness"], "stiffness_std": document.get("stiffness_std")}
    if one["value"] is None or other["value"] is None or one["std"] is None or other["std"] is None:
        return row
    change, std = other["value"] - one["value"], math.hypot(one["std"], other["std"])
    row |= {"change": change, "relative": change / one["value"] if one["value"] else None, "std": std}
    row["p_value"] = math.erfc(abs(change) / std / math.sqrt(2.0)) if std > 0.0 else None
    return row
