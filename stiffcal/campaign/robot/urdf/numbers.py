"""Numbers of a URDF: lengths and angles that may be in another unit, or no numbers."""

from __future__ import annotations

import math
from typing import TypeAlias

from stiffcal.campaign.robot.sizes import implausible_length
from stiffcal.campaign.toml.typed import WrongValueError
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

Triple: TypeAlias = tuple[float, float, float]

MOST_RAD = 200.0 * math.pi  # a hundred turns
ZERO: Triple = (0.0, 0.0, 0.0)


def triple_of(text: str | None, default: Triple, display_name: str, fault_place: str) -> Triple:
    """Return three finite numbers; the default where the text is missing, InputError where they are none."""
    if text is None:
        return default
    try:
        x, y, z = (float(number) for number in text.split())
    except ValueError:
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not three numbers', "write x y z"
        ) from None
    if not all(math.isfinite(number) for number in (x, y, z)):
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not three finite numbers', "write x y z"
        )
    return x, y, z


def position_of(text: str | None, display_name: str, fault_place: str) -> Triple:
    """Return a position, m; zero where the text is missing, InputError where a length is implausible."""
    position = triple_of(text, ZERO, display_name, fault_place)
    for length in position:
        refuse(implausible_length(length), display_name, fault_place)
    return position


def angles_of(text: str | None, display_name: str, fault_place: str) -> Triple:
    """Return three angles, rad; zero where the text is missing, InputError beyond a hundred turns."""
    angles = triple_of(text, ZERO, display_name, fault_place)
    for angle in angles:
        if abs(angle) > MOST_RAD:
            mend = f"write the angles in rad: if {angle:.6g} is in degrees, {math.radians(angle):.6g}"
            raise InputError.at(
                FaultCode.VALUE_INVALID,
                display_name,
                fault_place,
                f"rpy: {angle:.6g} rad is more than a hundred turns",
                mend,
            )
    return angles


def refuse(mistake: WrongValueError | None, display_name: str, fault_place: str) -> None:
    """Raise an `InputError` where there is a mistake."""
    if mistake is not None:
        raise InputError.at(FaultCode.VALUE_INVALID, display_name, fault_place, mistake.reason, mistake.mend)


def number_of(text: str | None, display_name: str, fault_place: str) -> float | None:
    """Return a number, infinity too; None where the text is missing, InputError where it is none."""
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not a number', "write a number"
        ) from None
    if math.isnan(value):
        raise InputError.at(
            FaultCode.NUMBER_INVALID, display_name, fault_place, f'"{text}" is not a number', "write a number"
        )
    return value
