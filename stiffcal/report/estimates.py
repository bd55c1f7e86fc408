"""Estimates in the report's tables: a value with ± 95 %, digits by the uncertainty, in the unit that people read.

One unit for a quantity in the whole report: lengths in mm, small angles in mrad.
"""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import estimate

STIFFNESS_UNITS = {"rad/(N·m)": ("N·m/rad", 1.0), "m/N": ("N/µm", 1e-6), "rad/N": ("N/mrad", 1e-3)}
"""Unit of a compliance to the unit of its stiffness, with the factor to it from SI units."""


def parameter_text(parameter: IdentifiedParameter, scale: float) -> str:
    """Return a parameter's value with ± 95 %, times `scale`."""
    return estimate(parameter.value, None if parameter.fixed else interval_of(parameter), scale)


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
    return estimate(value, interval, scale)
