"""What a change of the model, or a service of the robot, did to the identified values: before and after, with 95 %."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from stiffcal.documents import NOT_PROMISED, Number, OrAbsent
from stiffcal.identification.answers.fit_results import DriftFollows, IdentifiedParameter
from stiffcal.model.summary import Where


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


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatedValue:
    """An estimate with its 95 % interval."""

    value: Number
    """Null where it is not identified, or a stiffness without upper limit."""
    interval: list[Number] | None
    """Both ends of the 95 % interval, null where one is open; null where there is none."""
    at_bound: bool = False
    """Whether the value is at the limit of its range."""


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
    before: EstimatedValue | None
    """Null where the first model does not hold the parameter."""
    after: EstimatedValue | None
    """Null where the second model does not hold the parameter."""
    relative: Number
    """The change over the value before; null where one of the two is not known, or at the limit of its range."""
    outside_interval: bool
    """Whether the value after lies outside the 95 % interval before (of a value without one: the other way round)."""
    drift_follows: OrAbsent[DriftFollows] = None
    """Of a rate of drift: what the data count it by; None of others."""

    @property
    def setup_part(self) -> str:
        """The frame that a parameter of the set-up belongs to; "" of all others, and where there is one set-up."""
        if any(self.where.items()):
            return ""
        return self.name.removeprefix(f"{self.effect}.").rpartition(".")[0]


def stiffness_unit(compliance_unit: str) -> str:
    """Return the unit of one over a compliance.

    Examples
    --------
    >>> stiffness_unit("rad/(N·m)"), stiffness_unit("rad/N")
    ('N·m/rad', 'N/rad')
    """
    return {"rad/(N·m)": "N·m/rad", "m/N": "N/m", "rad/N": "N/rad"}.get(compliance_unit, f"1/({compliance_unit})")


def estimated_parameters(parameters: Sequence[IdentifiedParameter]) -> list[EstimatedParameter]:
    """Return parameters of a fit as people compare them, compliances as stiffness."""
    return [
        EstimatedParameter(
            name=parameter.name,
            effect=parameter.effect,
            where=parameter.where,
            unit=stiffness_unit(parameter.unit) if parameter.is_compliance else parameter.unit,
            value=parameter.known_stiffness if parameter.is_compliance else parameter.value,
            interval=parameter.stiffness_interval if parameter.is_compliance else parameter.interval,
            at_bound=parameter.at_bound,
            rests_on=parameter.rests_on,
            drift_follows=parameter.drift_follows,
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
        before=_value_of(first),
        after=_value_of(second),
        relative=_relative(first, second),
        outside_interval=both_known and _outside(first, second),
        drift_follows=either.drift_follows,
    )


def _relative(first: EstimatedParameter | None, second: EstimatedParameter | None) -> float | None:
    """Return the change over the value before; None where one is not known, or is only where its range ends."""
    if first is None or second is None or first.at_bound or second.at_bound:
        return None
    return second.value / first.value - 1.0 if first.value and second.value is not None else None


def _value_of(parameter: EstimatedParameter | None) -> EstimatedValue | None:
    return (
        None
        if parameter is None
        else EstimatedValue(value=parameter.value, interval=parameter.interval, at_bound=parameter.at_bound)
    )


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
