"""Joint angles of a run in another unit."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.runs.angle_units import DEGREE_UNITS
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant
from stiffcal.mistakes.suspect_kinds import SuspectKind


class JointsUnit(RunMistake):
    """All joint angles in degrees for rad, or the other way round."""

    name = "joints-unit"
    kind = SuspectKind.UNIT
    rank = 15

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with its angles multiplied."""
        for factor, text in DEGREE_UNITS:
            yield Variant(f"joint angles are {text}: multiply by {factor:.5g}", factor, joints=read.own.joints * factor)
