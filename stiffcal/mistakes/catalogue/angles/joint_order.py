"""Columns of joint angles in another order."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class JointOrder(InputMistake):
    """Two columns interchanged, or all reversed."""

    name = "joint-order"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS, TriedOn.REFERENCES, TriedOn.DISPLACEMENTS})
    rank = 24

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the angles with each two columns interchanged, and from wrist to base."""
        names = read.names
        for a, b in combinations(range(len(names)), 2):
            joints = read.joints.copy()
            joints[:, [a, b]] = read.joints[:, [b, a]]
            yield Way(read.with_joints(joints), (names[b], names[a]))
        if len(names) > 2:
            yield Way(read.with_joints(read.joints[:, ::-1]), names[::-1])

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = "name the joint columns from base to wrist"
        if len(change.names) > 2:
            words = "the order of the joints reversed"
            return ChangeTexts("joints", words, mend, "the order of the joint angles is reversed")
        pair = f"{change.names[1]} and {change.names[0]}"
        wrong = f"the angles of joints {pair} are interchanged"
        return ChangeTexts(f"joints {pair}", f"joint columns {pair} interchanged", mend, wrong)
