"""Numbers, poses and tools as options of commands give them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.toml.toml_reading import LARGEST
from stiffcal.compensation.table_doubts import angle_doubts
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.reduction.logs.reading_bounds import LARGEST_ANGLE_RAD, LONGEST_TRAVEL_M

if TYPE_CHECKING:
    from stiffcal.mechanics.chain import Chain


OPTION_IN_N = "the option takes N and N·m"


def pose_doubts(angles: Floats, chain: Chain, option: str) -> list[str]:
    """Return a warning where a pose of an option, (L,) rad and m, looks like radians."""
    turning = angles[~chain.prismatic]
    return angle_doubts(turning[None], option, "it takes degrees")


def pose_of_words(text: str, chain: Chain, option: str) -> Floats:
    """Return (L,) rad (prismatic joints: m) from "A1,A2,…" in degrees (mm); raises `InputError`."""
    names = chain.joint_names
    angles = numbers_of_words(text, option)
    if len(angles) != len(names):
        reason = f"{len(angles)} angles, the robot has {len(names)} joints"
        raise InputError.at(
            FaultCode.JOINT_COUNT, "command line", option, reason, f"give {', '.join(names)} in degrees"
        )
    pose = np.asarray(chain.from_printed(np.array(angles)))
    beyond = np.abs(pose) > np.where(chain.prismatic, LONGEST_TRAVEL_M, LARGEST_ANGLE_RAD)
    if beyond.any():
        joint = int(np.argmax(beyond))
        reason = f"{angles[joint]:.6g} is no position of joint {names[joint]}"
        mend = f"give {', '.join(names)} in degrees{', mm where they slide' if chain.prismatic.any() else ''}"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", option, reason, mend)
    return pose


def numbers_of_words(text: str, option: str) -> list[float]:
    """Return the numbers of "1,2.5,…"; raises `InputError`."""
    try:
        # answers are printed with a true minus sign, and copied from there
        numbers = [float(word) for word in text.replace("−", "-").split(",")]
    except ValueError:
        numbers = [float("nan")]
    if not np.isfinite(numbers).all():
        mend = "write numbers with a point, separated by commas"
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", option, f"{text!r} contains something that is not a number", mend
        )
    too_large = [value for value in numbers if abs(value) > LARGEST]
    if too_large:
        reason = f"{too_large[0]:g} is larger than any plausible value"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", option, reason, "correct the number")
    return numbers


def tool_of_words(text: str) -> tuple[float, Floats]:
    """Return mass, kg, and centre (3,), m, from "kg,x,y,z" of ``--tool``; raises `InputError`."""
    numbers = numbers_of_words(text, "--tool")
    if len(numbers) != 4 or numbers[0] <= 0.0:
        mend = "write kg,x,y,z: mass, and centre in the flange frame in m"
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--tool", f"{text!r} is not a mass with a centre", mend
        )
    return numbers[0], np.array(numbers[1:])


def tool_point(text: str) -> tuple[float, ...]:
    """Read a tool point as the command line gives it, ``X,Y,Z`` in m.

    Raises
    ------
    InputError : these are not three numbers, or a length that no robot has.

    Examples
    --------
    >>> tool_point("0, 0, 0.2")
    (0.0, 0.0, 0.2)
    """
    from stiffcal.campaign.robot.sizes import implausible_length

    numbers = numbers_of_words(text, "--tool")
    if len(numbers) != 3:
        reason = f"found {len(numbers)} number{'s' * (len(numbers) != 1)}"
        mend = "give X,Y,Z in m, in the flange frame"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--tool", reason, mend)
    for mistake in filter(None, map(implausible_length, numbers)):
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--tool", mistake.reason, mistake.mend)
    return tuple(numbers)
