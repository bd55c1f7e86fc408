"""An estimated value, the one type of it: a parameter, a stiffness, a width, before and after, in every medium."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

from stiffcal.documents import NOT_IN_DOCUMENT, Number
from stiffcal.quantity import Quantity
from stiffcal.uncertainty import NORMAL_95


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """An estimate with its 95 % interval."""

    value: Number
    """Null where it is not identified, or a stiffness without upper limit."""
    interval: list[Number] | None
    """Both ends of the 95 % interval, null where one is open; null where there is none."""
    at_bound: bool = False
    """Whether the value is at the limit of its range."""
    std: Annotated[Number, NOT_IN_DOCUMENT] = None
    """Standard uncertainty; None where none is known."""
    quantity: Annotated[Quantity | None, NOT_IN_DOCUMENT] = None
    """What it is of; None where what holds it says so."""
    is_fixed: Annotated[bool, NOT_IN_DOCUMENT] = False
    """Whether the model file gives the value."""
    is_identifiable: Annotated[bool, NOT_IN_DOCUMENT] = True
    """Whether these data distinguish it from others."""
    is_significant: Annotated[bool, NOT_IN_DOCUMENT] = True
    """Whether it exceeds three standard uncertainties, where that is asked."""
    is_poorly_determined: Annotated[bool, NOT_IN_DOCUMENT] = False
    """Whether its interval is nearly as wide as the value, or wider."""
    rests_on: Annotated[tuple[str, ...], NOT_IN_DOCUMENT] = ()
    """Parameters at a limit of their range that decide it."""
    includes: Annotated[tuple[str, ...], NOT_IN_DOCUMENT] = ()
    """Conventions of frames that a value of geometry holds: then it is not that of the robot alone."""
    is_supported: Annotated[bool, NOT_IN_DOCUMENT] = True
    """Whether the poses identify it: absolute places give a compliance a value where they do not."""
    is_shifted: Annotated[bool, NOT_IN_DOCUMENT] = False
    """Whether adding what the model lacks moves it beyond its interval: it is not to be used."""

    @classmethod
    def of(cls, value: float, std: float | None, quantity: Quantity | None = None) -> Estimate:
        """Return a value with the interval of its standard uncertainty, normal; no interval without one.

        Examples
        --------
        >>> Estimate.of(2.0, 0.5).interval, Estimate.of(2.0, None).interval
        ([1.020018007729973, 2.979981992270027], None)
        """
        half = None if std is None else NORMAL_95 * std
        interval: list[Number] | None = None if half is None else [value - half, value + half]
        return cls(value=value, std=std, interval=interval, quantity=quantity)

    @property
    def low(self) -> Number:
        """Lower end of the interval; None where it is open or there is none."""
        return None if self.interval is None else self.interval[0]

    @property
    def high(self) -> Number:
        """Upper end of the interval; None where it is open or there is none."""
        return None if self.interval is None else self.interval[1]

    @property
    def is_known(self) -> bool:
        """Whether there is a value, and it is not only where its range ends."""
        return self.value is not None and not self.at_bound

    @property
    def is_bounded(self) -> bool:
        """Whether there is a value, or a limit below which it is not."""
        return self.value is not None or self.low is not None

    def reciprocal(self) -> Estimate:
        """Return one over a value that is not negative: of a compliance the stiffness. One over 0 has no upper limit.

        Examples
        --------
        >>> Estimate(value=2e-6, interval=[1e-6, 4e-6]).reciprocal().interval
        [250000.0, 1000000.0]
        >>> give = Estimate(value=0.0, interval=[0.0, 1e-6]).reciprocal()
        >>> give.value, give.interval
        (None, [1000000.0, None])
        """
        value = 1.0 / self.value if self.value is not None and self.value > 0.0 else None
        low, high = (1.0 / end if end is not None and end > 0.0 else None for end in (self.high, self.low))
        return replace(
            self,
            value=value,
            interval=None if self.interval is None else [low, high],
            std=None if self.std is None or value is None else self.std * value**2,
            quantity=None if self.quantity is None else self.quantity.reciprocal(),
        )

    def relative_std(self) -> Number:
        """Return the standard uncertainty over the value; None where one is not known or 0."""
        return self.std / abs(self.value) if self.std and self.value and math.isfinite(self.std) else None
