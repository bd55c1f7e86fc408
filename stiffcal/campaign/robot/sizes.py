"""How large a robot's numbers can be, and which unit a number that is larger most likely has.

Places that were measured have no such limit: trackers count in the plant's coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema

from stiffcal.campaign.toml.typed import WrongValueError, array_schema, vector_of

LONGEST_M = 100.0  # ten times the reach of the largest robots
FARTHEST_ON_A_ROBOT_M = 10.0
"""Of a frame on the flange or a link from it: more than twice the reach of the largest arms; in mm a tool is longer."""
HEAVIEST_KG = 1e6  # a thousand times the mass of large ones
LARGEST_ANGLE_DEG = 36_000.0  # a hundred turns: an angle of a robot's geometry is below one
LARGEST_RATIO = 1e6
GRAVITY_MPS2 = (1.5, 15.0)  # between the Moon's and half as much again as the Earth's; and 0: weight left out


def implausible_length(metres: float, longest: float = LONGEST_M) -> WrongValueError | None:
    """Return the reason why a robot cannot have such a length, with a mend; None where it can.

    Parameters
    ----------
    longest : that is taken, m.

    Examples
    --------
    >>> print(implausible_length(1200.0))
    1200 m exceeds the size of any robot; 1200 looks like mm: write 1.2
    >>> implausible_length(-1.2)
    """
    if abs(metres) <= longest:
        return None
    unit, factor = ("mm", 1e-3) if abs(metres) <= 1e3 * LONGEST_M else ("µm", 1e-6)
    mend = f"{metres:.9g} looks like {unit}: write {metres * factor:.9g}"
    if not abs(metres) <= 1e6 * LONGEST_M:
        mend = "write it in m"
    return WrongValueError(f"{metres:.9g} m exceeds the size of any robot", mend)


def mass_mistake(kilograms: float) -> WrongValueError | None:
    """Return the reason why a robot cannot have such a mass, with a mend; None where it can.

    Examples
    --------
    >>> print(mass_mistake(1.2e6))
    1200000 kg exceeds the mass of any robot; 1200000 looks like g: write 1200
    >>> print(mass_mistake(-2.0))
    a mass of -2 kg; write the mass in kg, 0 where there is none
    """
    if kilograms < 0.0:
        return WrongValueError(f"a mass of {kilograms:.9g} kg", "write the mass in kg, 0 where there is none")
    if kilograms <= HEAVIEST_KG:
        return None
    mend = f"{kilograms:.9g} looks like g: write {kilograms / 1e3:.9g}" if kilograms <= 1e9 else "write it in kg"
    return WrongValueError(f"{kilograms:.9g} kg exceeds the mass of any robot", mend)


def angle_mistake(degrees: float) -> WrongValueError | None:
    """Return what is wrong with an angle of a robot's geometry, or None."""
    if abs(degrees) <= LARGEST_ANGLE_DEG:
        return None
    return WrongValueError(f"{degrees:.9g}° is more than a hundred turns", "write the angle in degrees")


def ratio_mistake(ratio: float) -> WrongValueError | None:
    """Return what is wrong with a ratio of two turns, or None; that it is not zero is checked elsewhere."""
    if ratio == 0.0 or 1.0 / LARGEST_RATIO <= abs(ratio) <= LARGEST_RATIO:
        return None
    return WrongValueError(f"a ratio of {ratio:.9g}", f"write a ratio of 1/{LARGEST_RATIO:.0g} to {LARGEST_RATIO:.0g}")


def gravity_mistake(gravity: Sequence[float]) -> WrongValueError | None:
    """Return what is wrong with the vector of gravity, or None; a vector of zeros leaves weight out.

    Examples
    --------
    >>> print(gravity_mistake((0.0, 0.0, -9810.0)))
    gravity of 9810 m/s²; 9810 looks like mm/s²: write 9.81
    """
    size = math.hypot(*gravity)
    if size == 0.0 or GRAVITY_MPS2[0] <= size <= GRAVITY_MPS2[1]:
        return None
    mend = "write it in m/s²: 9.81 on Earth, [0, 0, 0] without weight"
    if GRAVITY_MPS2[0] <= size / 1e3 <= GRAVITY_MPS2[1]:
        mend = f"{size:.9g} looks like mm/s²: write {size / 1e3:.9g}"
    elif abs(size - 1.0) < 0.05:
        mend = "1 looks like a multiple of g: write 9.81"
    return WrongValueError(f"gravity of {size:.9g} m/s²", mend)


def _length(value: float) -> float:
    return _checked(value, implausible_length(value))


def _mass(value: float) -> float:
    return _checked(value, mass_mistake(value))


def _angle(value: float) -> float:
    return _checked(value, angle_mistake(value))


def _ratio(value: float) -> float:
    return _checked(value, ratio_mistake(value))


def _checked(value: float, mistake: WrongValueError | None) -> float:
    if mistake is not None:
        raise mistake
    return value


def _place(value: tuple[float, float, float]) -> tuple[float, float, float]:
    for length in value:
        _checked(length, implausible_length(length))
    return value


def _gravity(value: tuple[float, float, float]) -> tuple[float, float, float]:
    mistake = gravity_mistake(value)
    if mistake is not None:
        raise mistake
    return value


_Vector: TypeAlias = Annotated[
    tuple[float, float, float], BeforeValidator(vector_of(3)), WithJsonSchema(array_schema(3))
]
Length: TypeAlias = Annotated[float, AfterValidator(_length)]
"""A length of the robot, m."""
Anywhere: TypeAlias = Annotated[float, Field(ge=-1e9, le=1e9)]
"""A length along a joint's axis, m, in a robot file: rows without β begin far away where axes are nearly parallel, so
that what is too long is seen in the rows together (`stiffcal.campaign.robot.robot_checks`)."""
PositiveLength: TypeAlias = Annotated[float, Field(gt=0), AfterValidator(_length)]
Mass: TypeAlias = Annotated[float, Field(ge=0), AfterValidator(_mass)]
"""A mass, kg."""
Degrees: TypeAlias = Annotated[float, AfterValidator(_angle)]
"""An angle of the robot's geometry, degrees."""
Ratio: TypeAlias = Annotated[float, AfterValidator(_ratio)]
PlaceOnRobot: TypeAlias = Annotated[_Vector, AfterValidator(_place)]
"""Three lengths of the robot, m."""
Gravity: TypeAlias = Annotated[_Vector, AfterValidator(_gravity)]
