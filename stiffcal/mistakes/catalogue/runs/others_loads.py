"""A run with the loads of another one."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, is_same
from stiffcal.mistakes.suspect_kinds import SuspectKind


class OthersLoads(RunMistake):
    """The loads that belong to the run are another run's."""

    name = "others-loads"
    kind = SuspectKind.EXCHANGED
    rank = 31
    of_two_runs = True

    def variants(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with each other run's loads."""
        for other in read.comparable:
            wrench = read.states.wrench[read.members[other]]
            if is_same(read.own.wrench, wrench):
                continue
            likely = (
                f'the loads that belong here are those of run "{read.name_of(other)}": the force logs are '
                "interchanged; interchange them back"
            )
            yield Variant(likely, wrench=wrench, other=other, penalty=read.mix_up_penalty(other))
