"""Moments of a run in another unit."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.runs.load_units import MOMENT_UNITS
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, scaled
from stiffcal.mistakes.suspect_kinds import SuspectKind


class MomentUnit(RunMistake):
    """Moments in another unit; forces are right."""

    name = "moment-unit"
    kind = SuspectKind.UNIT
    rank = 12

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with its moments multiplied."""
        if not read.own.setup.moments_measured:
            return
        for name, up, down in MOMENT_UNITS:
            for factor, text in ((up, f"in {name}"), (down, f"in N·m in a column of {name}")):
                likely = f"moments are {text}: multiply by {factor:.5g}"
                yield Variant(likely, factor, wrench=scaled(read.own.wrench, slice(3, 6), factor))
