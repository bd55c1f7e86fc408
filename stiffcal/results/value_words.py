"""Values of a model in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.wording import DASH, estimate

if TYPE_CHECKING:
    from stiffcal.identification.before_after import EstimatedValue


def value_in_model(value: EstimatedValue | None, factor: float = 1.0) -> str:
    """Return what a model has for a value, times `factor`; in words where it has none or none was found.

    Examples
    --------
    >>> value_in_model(None)
    'not in the model'
    """
    if value is None:
        return "not in the model"
    text = estimate(value.value, value.interval, factor, value.at_bound)
    return "not identified" if text == DASH else text
