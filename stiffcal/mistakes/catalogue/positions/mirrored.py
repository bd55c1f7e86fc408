"""All absolute places mirrored: two axes interchanged, or one with the other sign."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class Mirrored(InputMistake):
    """A mirror image; which one, an estimated frame leaves open."""

    name = "mirrored"
    part = InputPart.POSITIONS
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE})
    rank = 40

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the positions with the other sign of Z."""
        yield Way(replace(read.chosen, position=read.chosen.position * np.array([1.0, 1.0, -1.0])))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = "two of the columns X, Y and Z are interchanged, or one has the wrong sign: correct them"
        return ChangeTexts("columns of the positions", "the positions mirrored", mend)
