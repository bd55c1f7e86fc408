"""Values of a model in words, the same in terminal, report, page and notebook."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stiffcal import wording
from stiffcal.wording import AT_LIMIT, DASH, listing

if TYPE_CHECKING:
    from stiffcal.estimate import Estimate
    from stiffcal.identification.answers.before_after import BeforeAfter
    from stiffcal.identification.answers.fit_results import IdentifiedParameter
    from stiffcal.quantity import ShownUnit

SHIFTED = "shifted by what the model lacks"
SHIFTED_WORD = "shifted"
"""In a table, under which stands once by what."""


def as_shown(
    parameter: IdentifiedParameter, unclaimed: Collection[int] = (), shifted: Collection[str] = ()
) -> Estimate:
    """Return a parameter as tables show it: of a compliance the stiffness, with what other answers say of it.

    Parameters
    ----------
    parameter : of a fit. unclaimed : joints whose compliance the poses do not identify, as `validate` states.
    shifted : names of values that adding what the model lacks moves beyond their intervals, as `diagnose` states.
    """
    joints = parameter.where.joints or []
    is_unclaimed = parameter.is_compliance and parameter.value is not None and bool(set(joints) & set(unclaimed))
    return replace(parameter.as_read, is_supported=not is_unclaimed, is_shifted=parameter.name in shifted)


def shifted_values(changes: Iterable[BeforeAfter]) -> frozenset[str]:
    """Return the names of values that adding what the model lacks moves beyond their 95 % intervals."""
    return frozenset(change.name for change in changes if change.outside_interval and change.after is not None)


def shifted_warning(names: Collection[str]) -> list[str]:
    """Return a warning about the values that are shifted, for those who export a model; nothing where none is.

    Examples
    --------
    >>> shifted_warning({"joint-compliance.j4.c"})
    ['shifted by what the model lacks, not to be used: joint-compliance.j4.c']
    """
    return [f"{SHIFTED}, not to be used: {listing(sorted(names))}"] if names else []


def value_text(estimate: Estimate, unit: ShownUnit) -> str:
    """Return a value with its 95 % interval in the unit of its column; in words where none was found.

    Examples
    --------
    >>> from stiffcal.estimate import Estimate
    >>> from stiffcal.quantity import ShownUnit
    >>> unit = ShownUnit("mrad", 1e3)
    >>> value_text(Estimate(value=0.002, interval=[0.0019, 0.0021]), unit)
    '2.00 ± 0.10'
    >>> value_text(Estimate(value=0.002, interval=None, is_fixed=True), unit)
    '2.00 (fixed)'
    >>> value_text(Estimate(value=0.0, interval=None, is_fixed=True).reciprocal(), unit)
    'rigid (fixed)'
    >>> value_text(Estimate(value=None, interval=None, is_identifiable=False), unit)
    'not identifiable'
    """
    if estimate.is_fixed and estimate.is_identifiable:
        # what is fixed has a value: the stiffness of a compliance of zero has none
        value = "rigid" if estimate.value is None else wording.estimate(estimate.value, None, unit.factor)
        return f"{value} (fixed)"
    text = wording.estimate(estimate.value, estimate.interval, unit.factor)
    return text if estimate.is_identifiable and text != DASH else "not identifiable"


def remark(estimate: Estimate) -> str:
    """Return what is to be known of a value next to it, in the order of weight; "" where there is nothing.

    Examples
    --------
    >>> from stiffcal.estimate import Estimate
    >>> remark(Estimate(value=1.0, interval=[0.1, None], is_poorly_determined=True))
    'poorly determined, no upper bound'
    >>> remark(Estimate(value=1.0, interval=[0.9, 1.1], is_shifted=True))
    'shifted by what the model lacks'
    """
    return ", ".join(words for words in (_own_remark(estimate), SHIFTED if estimate.is_shifted else "") if words)


def _own_remark(estimate: Estimate) -> str:
    if estimate.is_poorly_determined:
        return "poorly determined" + (", no upper bound" if estimate.interval and estimate.high is None else "")
    if not estimate.is_identifiable or estimate.is_fixed:
        return ""  # the value says so itself
    if estimate.at_bound:
        return AT_LIMIT
    if estimate.rests_on:
        return on_limits(estimate.rests_on)
    if not estimate.is_significant:
        return "not significant (below 3σ)"
    if not estimate.is_supported:
        return "not identified by these poses"
    return f"includes {listing(estimate.includes)}" if estimate.includes else ""


def value_in_model(estimate: Estimate | None, unit: ShownUnit) -> str:
    """Return what a model has for a value, with its remark; where it has none, that.

    Examples
    --------
    >>> from stiffcal.quantity import ShownUnit
    >>> value_in_model(None, ShownUnit(""))
    'not in the model'
    """
    if estimate is None:
        return "not in the model"
    words = remark(estimate)
    return value_text(estimate, unit) + (f", {words}" if words else "")


def value_and_remark(estimate: Estimate | None, unit: ShownUnit) -> tuple[str, str]:
    """Return a value and what is to be known of it apart, which several values of a row may share.

    Of a shifted one a word: under the table stands once by what.
    """
    if estimate is None:
        return "not in the model", ""
    return value_text(estimate, unit), remark(estimate).replace(SHIFTED, SHIFTED_WORD)


def value_with_unit(estimate: Estimate | None, unit: ShownUnit) -> str:
    """Return the same for a sentence, with the unit behind the number.

    Examples
    --------
    >>> from stiffcal.estimate import Estimate
    >>> from stiffcal.quantity import STIFFNESS
    >>> value_with_unit(Estimate(value=None, interval=[1.3e7, None], at_bound=True), STIFFNESS.usual)
    'above 1.30·10⁷ N·m/rad, at its limit'
    """
    if estimate is None:
        return value_in_model(None, unit)
    words = remark(estimate)
    mark = unit.mark if estimate.is_bounded else ""
    return f"{value_text(estimate, unit)}{mark}{f', {words}' if words else ''}"


def on_limits(names: Sequence[str]) -> str:
    """Return that a value holds for others at the limit of their range alone, as a remark on it.

    Examples
    --------
    >>> on_limits(["backlash.j4.width"]), on_limits(["a", "b"])
    ('with backlash.j4.width at its limit', 'with a and b at their limits')
    """
    return f"with {listing(names)} at {'its limit' if len(names) == 1 else 'their limits'}"
