"""Other ways to count joint angles than stated: units, columns, directions, angles counted together.

On FANUC's and some other controllers the angle of joint 3 stands still while joint 2 moves the forearm: it is the sum
of two angles of the robot file, or the difference. So are angles of motors of a wrist, whose gears lie one in another.
`logged` of robot.toml states the sum.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.escapes import toml_text
from stiffcal.fault_changes import ChangeKind, InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain

# Where the search for a joint's zero begins, rad: the whole circle lies within half a quarter of one of them.
QUARTERS = (0.0, np.pi / 2, np.pi, -np.pi / 2)
# Of a joint before it: counted against it, not at all, or together with it.
_COUNTED = (-1.0, 0.0, 1.0)


@dataclass(frozen=True)
class CountedAngles:
    """Joint angles as they are if they were counted in another way than the robot file states."""

    joints: Floats
    """(n, L) rad, as they would be."""
    place: str
    """Of the mistake."""
    words: str
    """What is tried, as in "with … they agree"."""
    mend: str
    """What to write."""
    change: InputChange
    """The same as values."""
    code: FaultCode = FaultCode.KINEMATICS_MISMATCH
    """Of the mistake."""


def counted_otherwise(joints: Floats, chain: Chain) -> Iterator[CountedAngles]:
    """Yield all or one in another unit, two columns interchanged, another direction of a joint, or counted together.

    Parameters
    ----------
    joints : (n, L) logged, rad; m of prismatic joints. chain : the robot.
    """
    names = chain.joint_names if len(chain.joint_names) == joints.shape[1] else tuple(map(str, range(joints.shape[1])))
    for unit, name, other in (("deg", "degrees", np.radians(joints)), ("rad", "radians", np.degrees(joints))):
        angles = np.where(chain.prismatic, joints, other)
        mend = f"write {toml_text.pair('units', {'position': unit})}"
        change = InputChange(ChangeKind.ANGLE_UNIT, value=unit)
        yield CountedAngles(
            angles, "units.position", f"joint angles in {name}", mend, change, FaultCode.UNIT_IMPLAUSIBLE
        )
    for k in np.flatnonzero(~chain.prismatic[: joints.shape[1]]).tolist():
        angles = joints.copy()
        angles[:, k] = np.degrees(joints[:, k])
        words, mend = f"joint {names[k]} in radians", f"convert the column of {names[k]} to the unit of the others"
        change = InputChange(ChangeKind.ANGLE_UNIT, (names[k],), value="rad")
        yield CountedAngles(angles, f"joint {names[k]}", words, mend, change, FaultCode.UNIT_IMPLAUSIBLE)
    for a, b in combinations(range(joints.shape[1]), 2):
        angles = joints.copy()
        angles[:, [a, b]] = joints[:, [b, a]]
        pair = f"{names[a]} and {names[b]}"
        words = f"joint columns {pair} interchanged"
        change = InputChange(ChangeKind.JOINT_ORDER, (names[b], names[a]))
        yield CountedAngles(angles, f"joints {pair}", words, "name the joint columns from base to wrist", change)
    for k, name in enumerate(names):
        angles = joints.copy()
        angles[:, k] = -angles[:, k]
        words = f"joint {name} with opposite direction"
        mend, change = f"write direction = -1 (or 1) for {name}", InputChange(ChangeKind.DIRECTION, (name,))
        yield CountedAngles(angles, f"joint {name}", words, mend, change)
    yield from coupled_angles(joints, chain)


def coupled_angles(joints: Floats, chain: Chain) -> Iterator[CountedAngles]:
    """Yield the angles with each turning joint counted otherwise together with one before it.

    Parameters
    ----------
    joints : (n, L) logged, rad. chain : the robot.
    """
    if len(chain.joint_names) != joints.shape[1]:
        return
    turning = [joint for joint in range(min(joints.shape[1], chain.n_joints)) if not chain.prismatic[joint]]
    for first, second in combinations(turning, 2):
        one, other = chain.joint_names[first], chain.joint_names[second]
        stated = float(chain.coupling[second, first] / chain.coupling[second, second])
        for counted in _COUNTED:
            share = counted - stated
            if abs(share) not in (1.0, 2.0):  # nothing changes, or a gear between the two is stated
                continue
            angles = joints.copy()
            angles[:, second] += share * joints[:, first]
            amount = f"{'+' if share > 0.0 else '−'} {'2·' if abs(share) == 2.0 else ''}{one}"
            yield CountedAngles(
                angles,
                f"joints {one} and {other}",
                f"{other} {amount} in place of {other}",
                _mend(one, other, stated, counted, bool(chain.mechanical[second])),
                InputChange(ChangeKind.COUNTED_TOGETHER, (one, other), (share,)),
            )


def _mend(one: str, other: str, stated: float, counted: float, mechanical: bool) -> str:
    """Return what to write where a robot file counts joint ``other`` with ``stated`` times joint ``one`` before it."""
    if not stated:
        return (
            f"the table counts {other} together with {one}, as controllers do against the horizontal: write "
            f"{toml_text.pair('logged', {one: int(counted), other: 1})} for joint {other} in the robot file"
        )
    if counted:
        return f"{one} counts with the other sign: change its sign in `logged` of joint {other} in the robot file"
    if mechanical:
        # its spring stays on the axis that the rod holds, which the robot file describes by `logged` as well
        sign = "−" if stated > 0.0 else "+"
        return (
            f"the table counts {other} against the link before it, where the robot file has a rod that holds it: give "
            f"the column of {other} as {other} {sign} {one}"
        )
    return (
        f"the table counts {other} by itself, as against the link before it: remove {one} from `logged` of joint "
        f"{other} in the robot file"
    )
