"""Estimates in the report's tables: a value with ± 95 %, digits by the uncertainty, in the unit that people read.

One unit for a quantity in the whole report: lengths in mm, small angles in mrad.
"""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.identification.fit_results import IdentifiedParameter
from stiffcal.report import wording
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import estimate

STIFFNESS_UNITS = {"rad/(N·m)": ("N·m/rad", 1.0), "m/N": ("N/µm", 1e-6), "rad/N": ("N/mrad", 1e-3)}
"""Unit of a compliance to the unit of its stiffness, with the factor to it from SI units."""


def estimate_text(value: float | None, interval: Sequence[float | None] | None, scale: float = 1.0) -> str:
    """Return a value with ± 95 %; the interval's ends where it is lopsided or open.

    Parameters
    ----------
    value : None where none was found. interval : its 95 % interval; None: not known. scale : factor on all three.

    Examples
    --------
    >>> estimate_text(2.7e6, [2.694e6, 2.706e6]), estimate_text(2.0, [1.0, None]), estimate_text(None, None)
    ('(2.7000 ± 0.0060)·10⁶', '2.00 (above 1.00)', '–')
    """
    low, high = (None if end is None else end * scale for end in interval or (None, None))
    if value is None:
        return f"above {wording.significant(low)}" if low is not None else wording.DASH
    return wording.significant(value * scale) if interval is None else estimate(value * scale, low, high)


def parameter_text(parameter: IdentifiedParameter, scale: float) -> str:
    """Return a parameter's value with ± 95 %, times `scale`."""
    return estimate_text(parameter.value, None if parameter.fixed else interval_of(parameter), scale)


def interval_of(parameter: IdentifiedParameter) -> Sequence[float | None] | None:
    """Return the 95 % interval of a parameter, by its standard uncertainty where none was computed."""
    if parameter.interval is not None or parameter.value is None or parameter.std is None:
        return parameter.interval
    half = NORMAL_95 * parameter.std
    return [parameter.value - half, parameter.value + half]


def stiffness_text(spring: IdentifiedParameter, scale: float) -> str:
    """Return the stiffness of a compliance with ± 95 %, times `scale`."""
    value, std, interval = spring.known_stiffness, spring.known_stiffness_std, spring.stiffness_interval
    if spring.fixed:
        interval = None
    elif interval is None and value is not None and std is not None:
        interval = [value - NORMAL_95 * std, value + NORMAL_95 * std]
    return estimate_text(value, interval, scale)
