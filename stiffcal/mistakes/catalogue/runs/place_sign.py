"""A coordinate of a run's places in the opposite direction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant
from stiffcal.mistakes.suspect_kinds import SuspectKind


class PlaceSign(RunMistake):
    """One coordinate of the places, in the tracker's axes, in the opposite direction."""

    name = "place-sign"
    kind = SuspectKind.SIGN
    rank = 22

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with its places mirrored."""
        own = read.own
        if own.deflection_given:
            return
        turn = own.base_from_tracker[0]
        for component, name in enumerate("xyz"):
            flip = np.eye(4)
            flip[component, component] = -1.0
            flip_in_base = turn @ flip @ np.linalg.inv(turn)
            likely = f"the place {name} has the wrong sign: multiply it by −1"
            yield Variant(likely, -1.0, position=own.position @ flip_in_base[:3, :3].T + flip_in_base[:3, 3])
