"""Quantities as people read them: the SI unit of answers, the units that are shown and where they change, digits.

One table for terminal, report, page, notebook and documents. A column, and all that one answer states of a quantity,
has one unit, by the largest number there: numbers below each other are compared. (Units in which logs are written
stand in `stiffcal.quantities`.)
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, Protocol, TypeAlias

DriftFollows: TypeAlias = Literal["time", "temperature"]


class Measures(Protocol):
    """An error, measure by measure."""

    def items(self) -> Iterable[tuple[str, float | None]]:
        """Return the measures that apply, by name, SI."""


@dataclass(frozen=True, slots=True)
class ShownUnit:
    """A unit that people read."""

    name: str
    """As it is printed; "" of a plain number."""
    factor: float = 1.0
    """From SI to it."""
    least: float = 0.0
    """SI: the largest number of a column from which on the unit is taken."""
    zero: float = 0.0
    """SI: where the unit is 0."""

    @property
    def mark(self) -> str:
        """What stands behind a number: a degree's sign without a space."""
        return self.name if self.name in ("", "°") else f" {self.name}"

    def in_brackets(self, label: str) -> str:
        """Return an axis's or a column's label with the unit.

        Examples
        --------
        >>> ShownUnit("mm").in_brackets("error"), ShownUnit("").in_brackets("share")
        ('error [mm]', 'share')
        """
        return f"{label} [{self.name}]" if self.name else label


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a number is of."""

    si: str
    """Its unit in documents, as it is printed: "rad/(N·m)"."""
    shown: tuple[ShownUnit, ...]
    """The units that people read, that of large numbers first; the first one is usual."""
    inverse: str = ""
    """SI unit of one over it, where that is read in its place: a compliance's stiffness."""
    digits: int = 3
    """Significant ones, of a number without uncertainty."""
    rounding: float = 0.0
    """SI: below it a number is some computation's rounding."""

    @property
    def usual(self) -> ShownUnit:
        """The unit where nothing else is compared with a number."""
        return self.shown[0]

    def unit_for(self, numbers: Iterable[float | None]) -> ShownUnit:
        """Return the one unit of all numbers of a column or an answer, by the largest; the usual one for none.

        Parameters
        ----------
        numbers : SI; None and what is not finite do not count, nor does a computation's rounding.

        Examples
        --------
        >>> LENGTH.unit_for([2e-6, 3.1e-4]).name, LENGTH.unit_for([2e-6, None]).name, LENGTH.unit_for([]).name
        ('mm', 'µm', 'mm')
        """
        known = (abs(number) for number in numbers if number is not None and math.isfinite(number))
        largest = max(known, default=0.0)
        if largest <= self.rounding:
            return self.usual
        return next((unit for unit in self.shown if largest >= unit.least), self.shown[-1])

    def reciprocal(self) -> Quantity:
        """Return what one over the quantity is.

        Examples
        --------
        >>> COMPLIANCE.reciprocal().si, quantity_of("m/N").reciprocal().usual.name
        ('N·m/rad', 'N/µm')
        """
        return quantity_of(self.inverse or f"1/({self.si})")


LENGTH: Final = Quantity("m", (ShownUnit("mm", 1e3, 1e-5), ShownUnit("µm", 1e6)), rounding=1e-9)
"""Displacements, positions, errors."""
ANGLE: Final = Quantity("rad", (ShownUnit("mrad", 1e3, 1e-5), ShownUnit("µrad", 1e6)), rounding=1e-9)
"""Small angles: rotations, errors, widths."""
JOINT_ANGLE: Final = Quantity("rad", (ShownUnit("°", 180.0 / math.pi),))
"""Where a joint stands."""
FORCE: Final = Quantity("N", (ShownUnit("N"),))
MOMENT: Final = Quantity("N·m", (ShownUnit("N·m"),))
DELAY: Final = Quantity("s", (ShownUnit("ms", 1e3),))
"""Offsets of clocks, delays of filters."""
TEMPERATURE: Final = Quantity("K", (ShownUnit("°C", zero=273.15),))
SHARE: Final = Quantity("1", (ShownUnit("%", 1e2),))
RATE: Final = Quantity("1", (ShownUnit("ppm", 1e6),))
"""How much a clock gains."""
COMPLIANCE: Final = Quantity(
    "rad/(N·m)", (ShownUnit("µrad/(N·m)", 1e6, 1e-8), ShownUnit("nrad/(N·m)", 1e9)), inverse="N·m/rad"
)
STIFFNESS: Final = Quantity("N·m/rad", (ShownUnit("N·m/rad"),), inverse="rad/(N·m)")
LINEAR_COMPLIANCE: Final = Quantity("m/N", (ShownUnit("µm/N", 1e6, 1e-9), ShownUnit("nm/N", 1e9)), inverse="N/m")
LINEAR_STIFFNESS: Final = Quantity("N/m", (ShownUnit("N/µm", 1e-6, 1e4), ShownUnit("N/mm", 1e-3)), inverse="m/N")

ROTATIONAL_STIFFNESS: Final = Quantity("N·m/rad", (ShownUnit("kN·m/rad", 1e-3),), inverse="rad/(N·m)")
"""Of a whole robot about an axis."""

_NAMED: Final = (LENGTH, ANGLE, FORCE, MOMENT, COMPLIANCE, STIFFNESS, LINEAR_COMPLIANCE, LINEAR_STIFFNESS)
_OTHERS: Final = (
    Quantity("1", (ShownUnit(""),)),
    Quantity("rad/N", (ShownUnit("µrad/N", 1e6),), inverse="N/rad"),
    Quantity("N/rad", (ShownUnit("N/mrad", 1e-3),), inverse="rad/N"),
)
_BY_UNIT: Final[Mapping[str, Quantity]] = {quantity.si: quantity for quantity in (*_NAMED, *_OTHERS)}
_DRIFTS: Final[Mapping[tuple[str, DriftFollows], Quantity]] = {
    ("m/s or m/K", "time"): Quantity("m/s", (ShownUnit("µm/h", 3.6e9),)),
    ("m/s or m/K", "temperature"): Quantity("m/K", (ShownUnit("µm/K", 1e6),)),
    ("rad/s or rad/K", "time"): Quantity("rad/s", (ShownUnit("mrad/h", 3.6e6),)),
    ("rad/s or rad/K", "temperature"): Quantity("rad/K", (ShownUnit("mrad/K", 1e3),)),
}
_OF_MEASURES: Final[Mapping[str, Quantity]] = {
    "translation": LENGTH,
    "rotation": ANGLE,
    "length": LENGTH,
    "motor_angle": ANGLE,
    "torque": MOMENT,
}


def quantity_of(unit: str, drift_follows: str | None = None) -> Quantity:
    """Return what a value is of, from its unit in a document; a unit that the table does not hold is shown as it is.

    Parameters
    ----------
    unit : "rad/(N*m)". drift_follows : of a rate of drift what it is counted by; None of others.

    Examples
    --------
    >>> quantity_of("rad").usual.name, quantity_of("m/s or m/K", "time").usual.name, quantity_of("N*m^2").usual.name
    ('mrad', 'µm/h', 'N·m²')
    """
    words = unit_words(unit)
    drift = next((one for (own, by), one in _DRIFTS.items() if (own, by) == (words, drift_follows)), None)
    return drift or _BY_UNIT.get(words) or Quantity(words, (ShownUnit(words),))


def is_drift(unit: str) -> bool:
    """Return whether a unit is that of a rate of drift, which the data count by time or by temperature."""
    return any(unit_words(unit) == own for own, _ in _DRIFTS)


def of_measure(name: str) -> Quantity:
    """Return what a measure of an error is: "translation", "rotation", "length", "motor_angle", "torque".

    Examples
    --------
    >>> of_measure("rotation").usual.name
    'mrad'
    """
    return _OF_MEASURES[name]


def of_component(k: int) -> Quantity:
    """Return what a component of a deflection is: three of translation, then three of rotation."""
    return LENGTH if k < 3 else ANGLE


def of_load(k: int) -> Quantity:
    """Return what a component of a wrench is: three of force, then three of moment."""
    return FORCE if k < 3 else MOMENT


def of_stiffness(k: int) -> Quantity:
    """Return what an element of a Cartesian stiffness's diagonal is: along three axes, then about them."""
    return LINEAR_STIFFNESS if k < 3 else ROTATIONAL_STIFFNESS


def of_joint(is_prismatic: bool) -> Quantity:
    """Return what a joint's position is."""
    return LENGTH if is_prismatic else JOINT_ANGLE


class Units:
    """The one unit of each quantity in an answer, by the largest number that it states of it.

    Examples
    --------
    >>> units = Units([("m", [3e-6, 8e-6]), ("rad", [2e-3])])
    >>> units.of(LENGTH).name, units.of(ANGLE).name, units.of(FORCE).name
    ('µm', 'mrad', 'N')
    """

    def __init__(self, numbers: Iterable[tuple[str | Quantity, Iterable[float | None]]] = ()) -> None:
        collected: dict[Quantity, list[float | None]] = {}
        for unit, values in numbers:
            quantity = quantity_of(unit) if isinstance(unit, str) else unit
            collected.setdefault(quantity, []).extend(values)
        self._chosen = {quantity: quantity.unit_for(values) for quantity, values in collected.items()}

    @classmethod
    def of_errors(cls, errors: Iterable[Measures | None]) -> Units:
        """Return the units of errors ``{translation, rotation, …}`` that one answer states; None: not known."""
        return cls((of_measure(name), [value]) for error in errors if error for name, value in error.items())

    def of(self, quantity: Quantity) -> ShownUnit:
        """Return the unit in which all numbers of a quantity are shown here."""
        return self._chosen.get(quantity, quantity.usual)


USUAL: Final = Units()
"""Where nothing is compared: the usual unit of each quantity."""


def unit_words(unit: str) -> str:
    """Return a unit of a document as it is printed.

    Examples
    --------
    >>> unit_words("rad/(N*m)"), unit_words("N*m^2"), unit_words("um")
    ('rad/(N·m)', 'N·m²', 'µm')
    """
    micro = re.sub(r"\bu(?=(?:m|N|rad)\b)", "µ", unit)
    return micro.replace("*", "·").replace("^2", "²").replace("^3", "³").replace("degC", "°C")
