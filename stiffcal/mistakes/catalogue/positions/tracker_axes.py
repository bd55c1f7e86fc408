"""Columns of a tracker's readings in another order, or with other signs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.measurements.tracker_axes import places_in_tracker, with_places_in_tracker
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class TrackerAxes(InputMistake):
    """Other axes of the tracker."""

    name = "tracker-axes"
    part = InputPart.POSITIONS
    tried_on = frozenset({TriedOn.REFERENCES})
    rank = 32

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the positions with the axes of the tracker in each order, with each signs."""
        own = places_in_tracker(read.chosen)
        for order in permutations(range(3)):
            for signs in product((1.0, -1.0), repeat=3):
                if order == (0, 1, 2) and signs == (1.0, 1.0, 1.0):
                    continue
                axes = tuple(f"{'-' if s < 0 else ''}{'XYZ'[k]}" for k, s in zip(order, signs, strict=True))
                yield Way(with_places_in_tracker(read.chosen, own[..., order] * np.array(signs)), axes)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        words = f"the tracker's axes as ({', '.join(change.names)})"
        mend = "correct the order of position's columns, or the frame"
        return ChangeTexts("columns of the positions", words, mend)
