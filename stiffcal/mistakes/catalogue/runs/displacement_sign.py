"""Displacements of a run in the opposite direction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, scaled
from stiffcal.mistakes.suspect_kinds import SuspectKind


class DisplacementSign(RunMistake):
    """One component of the displacement, or all of it, in the opposite direction."""

    name = "displacement-sign"
    kind = SuspectKind.SIGN
    rank = 21

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with components of its displacement reversed."""
        own = read.own
        if not own.deflection_given:
            return
        for component, name in enumerate(("x", "y", "z", "rx", "ry", "rz")):
            if np.any(np.nan_to_num(own.deflection[:, :, component])):
                likely = f"the displacement {name} has the wrong sign: multiply it by −1"
                yield Variant(likely, -1.0, deflection=scaled(own.deflection, component, -1.0))
        likely = "the displacement has the wrong sign, unloaded minus loaded: multiply it by −1"
        yield Variant(likely, -1.0, deflection=-own.deflection)
