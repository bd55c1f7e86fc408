"""What a change of the model, or a service of the robot, did to the identified values: before and after, with 95 %."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from stiffcal.documents import NOT_IN_DOCUMENT, NOT_PROMISED, Number, OrAbsent
from stiffcal.estimate import Estimate
from stiffcal.model.summary import Where
from stiffcal.quantity import DriftFollows, Quantity, Units, quantity_of

if TYPE_CHECKING:
    from stiffcal.identification.answers.fit_results import IdentifiedParameter


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatedParameter:
    """A parameter as people compare it: of a compliance the stiffness."""

    name: str
    """``effect.place.symbol``."""
    effect: str
    """The effect's name."""
    where: Where
    """The effect's place."""
    unit: str
    """Of the value; of a compliance that of the stiffness, e.g. N·m/rad."""
    value: Number
    """Null where it is not identified, or a stiffness without upper limit."""
    interval: list[Number] | None
    """Both ends of the 95 % interval, null where one is open; null where there is none."""
    at_bound: bool = False
    """Whether the value is at the limit of its range."""
    rests_on: Annotated[OrAbsent[list[str]], NOT_PROMISED] = None
    """As of `IdentifiedParameter`."""
    drift_follows: OrAbsent[DriftFollows] = None
    """Of a rate of drift: what the data count it by; None of others."""
    is_shifted: Annotated[bool, NOT_IN_DOCUMENT] = False
    """As of `Estimate`."""

    @property
    def quantity(self) -> Quantity:
        """What the value is of."""
        return quantity_of(self.unit, self.drift_follows)

    @property
    def estimate(self) -> Estimate:
        """The value with its interval."""
        return Estimate(
            value=self.value,
            interval=self.interval,
            at_bound=self.at_bound,
            quantity=self.quantity,
            rests_on=tuple(self.rests_on or ()),
            is_shifted=self.is_shifted,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class BeforeAfter:
    """A parameter before and after a change, of a compliance the stiffness."""

    name: str
    """``effect.place.symbol``."""
    effect: str
    """The effect's name."""
    where: Where
    """The effect's place."""
    unit: str
    """Of both values; of a compliance that of the stiffness, e.g. N·m/rad."""
    before: Estimate | None
    """Null where the first model does not hold the parameter."""
    after: Estimate | None
    """Null where the second model does not hold the parameter."""
    relative: Number
    """The change over the value before; null where one of the two is not known, or at the limit of its range."""
    outside_interval: bool
    """Whether the value after lies outside the 95 % interval before (of a value without one: the other way round)."""
    drift_follows: OrAbsent[DriftFollows] = None
    """Of a rate of drift: what the data count it by; None of others."""

    @property
    def quantity(self) -> Quantity:
        """What both values are of."""
        return quantity_of(self.unit, self.drift_follows)

    @property
    def setup_part(self) -> str:
        """The frame that a parameter of the set-up belongs to; "" of all others, and where there is one set-up."""
        if any(self.where.items()):
            return ""
        part = self.name.removeprefix(f"{self.effect}.").rpartition(".")[0]
        return "" if part == "setup" else part


def units_of_values(values: Iterable[BeforeAfter]) -> Units:
    """Return the units in which a table of values before and after shows them."""
    return Units(
        (value.quantity, [one.value for one in (value.before, value.after) if one is not None]) for value in values
    )


def estimated_parameters(
    parameters: Sequence[IdentifiedParameter], shifted: Collection[str] = ()
) -> list[EstimatedParameter]:
    """Return parameters of a fit as people compare them, compliances as stiffness.

    Parameters
    ----------
    parameters : of a fit. shifted : names of values that adding what the model lacks moves beyond their intervals.
    """
    return [
        EstimatedParameter(
            name=parameter.name,
            effect=parameter.effect,
            where=parameter.where,
            unit=parameter.quantity.reciprocal().si if parameter.is_compliance else parameter.unit,
            value=parameter.known_stiffness if parameter.is_compliance else parameter.value,
            interval=parameter.stiffness_interval if parameter.is_compliance else parameter.interval,
            at_bound=parameter.at_bound,
            rests_on=parameter.rests_on,
            drift_follows=parameter.drift_follows,
            is_shifted=parameter.name in shifted,
        )
        for parameter in parameters
    ]


def values_before_and_after(
    before: Sequence[EstimatedParameter], after: Sequence[EstimatedParameter]
) -> list[BeforeAfter]:
    """Return each parameter of two fits, in the order of the second one, then those that only the first one holds.

    Parameters
    ----------
    before, after : the parameters of both fits.
    """
    first, second = ({parameter.name: parameter for parameter in fit} for fit in (before, after))
    return [
        _before_after(second.get(name) or first[name], first.get(name), second.get(name))
        for name in dict.fromkeys((*second, *first))
    ]


def _before_after(
    either: EstimatedParameter, first: EstimatedParameter | None, second: EstimatedParameter | None
) -> BeforeAfter:
    both_known = first is not None and second is not None
    return BeforeAfter(
        name=either.name,
        effect=either.effect,
        where=either.where,
        unit=either.unit,
        before=None if first is None else first.estimate,
        after=None if second is None else second.estimate,
        relative=_relative(first, second),
        outside_interval=both_known and _outside(first, second),
        drift_follows=either.drift_follows,
    )


def _relative(first: EstimatedParameter | None, second: EstimatedParameter | None) -> float | None:
    """Return the change over the value before; None where one is not known, or is only where its range ends."""
    if first is None or second is None or first.at_bound or second.at_bound:
        return None
    return second.value / first.value - 1.0 if first.value and second.value is not None else None


def _outside(before: EstimatedParameter | None, after: EstimatedParameter | None) -> bool:
    """Return whether the second value lies outside the interval of the first one."""
    if before is None or after is None:
        return False
    if before.interval is None:
        return after.interval is not None and _outside(after, before)
    low, high = before.interval
    least = most = after.value
    if after.value is None and after.interval is not None:
        # No upper limit to a stiffness: nothing but its lower limit is known.
        least = after.interval[0]
    return (least is not None and high is not None and least > high) or (
        most is not None and low is not None and most < low
    )
