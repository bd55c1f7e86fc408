"""A joint that is counted in the other direction."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way
from stiffcal.mistakes.words import reading_of


class Direction(InputMistake):
    """The other direction of one joint."""

    name = "direction"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS, TriedOn.REFERENCES, TriedOn.DISPLACEMENTS})
    rank = 20

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the angles of each joint with the other sign."""
        for k, name in enumerate(read.names):
            yield Way(read.with_joint(k, -read.joints[:, k]), (name,))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        (name,) = change.names
        return ChangeTexts(
            f"joint {name}",
            f"joint {name} with opposite direction",
            f"change the sign of direction of joint {name} in the robot file, or of its column",
            f"{reading_of(name, chain)} has the wrong sign",
        )
