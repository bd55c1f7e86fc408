"""A joint whose encoder sits behind a gear of two to one, and logs half of the angle."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class HalvedAngle(InputMistake):
    """Twice the angle of one joint."""

    name = "halved-angle"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS, TriedOn.REFERENCES, TriedOn.DISPLACEMENTS})

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the angles with that of each joint doubled."""
        for k, name in enumerate(read.names):
            yield Way(read.with_joint(k, 2.0 * read.joints[:, k]), (name,))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (name,) = change.names
        mend = f"double the column of {name}: its encoder turns half as far as the joint"
        return ChangeTexts(f"joint {name}", f"joint {name} doubled", mend, f"the angle of joint {name} is halved")
