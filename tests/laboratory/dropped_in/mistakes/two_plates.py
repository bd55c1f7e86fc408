"""Of two plates that were hung on as the load one was entered."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant
from stiffcal.mistakes.suspect_kinds import SuspectKind


class TwoPlates(RunMistake):
    """Half of the load in all states of a run."""

    name = "two-plates"
    kind = SuspectKind.UNIT

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with twice its load."""
        yield Variant("two plates, of which one was entered: multiply by 2", 2.0, wrench=2.0 * read.own.wrench)
