"""A joint angle that is counted together with one before it, or is not where the robot file has it so.

On FANUC's and some other controllers the angle of joint 3 stands still while joint 2 moves the forearm: it is the sum
of two angles of the robot file, or the difference. So are angles of motors of a wrist, whose gears lie one in another.
`logged` of robot.toml states the sum.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way

# Of a joint before it: counted against it, not at all, or together with it.
_COUNTED = (-1.0, 0.0, 1.0)
# By so much the count then differs from the stated one; otherwise nothing changes, or a gear between the two is stated.
_DIFFERENCES = (1.0, 2.0)


class CountedTogether(InputMistake):
    """Another sum of two angles."""

    name = "counted-together"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS, TriedOn.REFERENCES, TriedOn.DISPLACEMENTS})
    rank = 23

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the angles with each turning joint counted otherwise together with one before it."""
        joints, chain = read.joints, read.chain
        if len(chain.joint_names) != joints.shape[1]:
            return
        turning = [joint for joint in range(min(joints.shape[1], chain.n_joints)) if not chain.prismatic[joint]]
        for first, second in combinations(turning, 2):
            for counted in _COUNTED:
                share = counted - _stated(chain, first, second)
                if abs(share) in _DIFFERENCES:
                    states = read.with_joint(second, joints[:, second] + share * joints[:, first])
                    yield Way(states, (chain.joint_names[first], chain.joint_names[second]), (share,))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        one, other = change.names
        (share,) = change.sizes
        amount = f"{'+' if share > 0.0 else '−'} {'2·' if abs(share) == 2.0 else ''}{one}"
        first, second = chain.joint_names.index(one), chain.joint_names.index(other)
        stated = _stated(chain, first, second)
        mend = _mend(one, other, stated, stated + share, bool(chain.mechanical[second]))
        place = f"joints {one} and {other}"
        wrong = f"the angles of {place} are counted together where those of the others are not"
        return ChangeTexts(place, f"{other} {amount} in place of {other}", mend, wrong)


def _stated(chain: Chain, first: int, second: int) -> float:
    """Return how many times the robot file counts one joint in the angle of a later one."""
    return float(chain.coupling[second, first] / chain.coupling[second, second])


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
