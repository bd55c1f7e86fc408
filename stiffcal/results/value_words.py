"""Values of a model in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.wording import DASH, estimate, listing

if TYPE_CHECKING:
    from stiffcal.identification.answers.before_after import EstimatedValue


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


def on_limits(names: Sequence[str]) -> str:
    """Return that a value holds for others at the limit of their range alone, as a remark on it.

    Examples
    --------
    >>> on_limits(["backlash.j4.width"]), on_limits(["a", "b"])
    ('with backlash.j4.width at its limit', 'with a and b at their limits')
    """
    return f"with {listing(names)} at {'its limit' if len(names) == 1 else 'their limits'}"
