"""Measured rotations of a run in another unit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.runs.angle_units import ANGLE_UNITS
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, scaled
from stiffcal.mistakes.suspect_kinds import SuspectKind


class RotationUnit(RunMistake):
    """Rotations of the target in another unit."""

    name = "rotation-unit"
    kind = SuspectKind.UNIT
    rank = 14

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with its rotations multiplied."""
        turned = read.own.deflection
        if not np.isfinite(turned[:, :, 3:]).any():
            return
        for factor, text in ANGLE_UNITS:
            likely = f"rotations are {text}: multiply by {factor:.5g}"
            yield Variant(likely, factor, deflection=scaled(turned, slice(3, 6), factor))
