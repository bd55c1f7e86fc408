"""The pose of the base in the tracker's frame, written as that of the tracker in the base frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.measurements.tracker_axes import places_in_tracker
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import inverse_transform
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class InverseFrame(InputMistake):
    """The inverse of the tracker's frame."""

    name = "inverse-frame"
    part = InputPart.FRAMES
    tried_on = frozenset({TriedOn.REFERENCES})
    rank = 34

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the positions as the inverse frame has them."""
        placed = inverse_transform(read.chosen.base_from_tracker)
        turned = np.einsum("nij,nbj->nbi", placed[:, :3, :3], places_in_tracker(read.chosen))
        yield Way(replace(read.chosen, position=turned + placed[:, None, :3, 3]))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = "frames.tracker is the pose of the tracker in the base frame, not of the base in the tracker frame"
        return ChangeTexts("frames.tracker", "the inverse of the tracker frame", mend)
