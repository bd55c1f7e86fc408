"""All joints counted in the other direction: a mirror image, as an interchange of two axes is."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class AllDirections(InputMistake):
    """The other direction of all joints."""

    name = "direction"
    part = InputPart.ANGLES
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE})
    # after the mirrored positions, which are made more often
    rank = 41

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield all angles with the other sign."""
        yield Way(read.with_joints(-read.joints), read.names)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = "change the sign of direction of all joints in the robot file, or of the columns of their angles"
        return ChangeTexts("joints", "all joints with opposite direction", mend)
