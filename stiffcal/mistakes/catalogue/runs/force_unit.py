"""Forces of a run in another unit."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.runs.load_units import FORCE_FACTORS
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, scaled
from stiffcal.mistakes.suspect_kinds import SuspectKind


class ForceUnit(RunMistake):
    """Forces in another unit; moments, where measured, are right."""

    name = "force-unit"
    kind = SuspectKind.UNIT
    rank = 10

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with its forces multiplied."""
        for factor, text in FORCE_FACTORS:
            likely = f"forces {text}: multiply by {factor:.5g}"
            yield Variant(likely, factor, wrench=scaled(read.own.wrench, slice(0, 3), factor))
