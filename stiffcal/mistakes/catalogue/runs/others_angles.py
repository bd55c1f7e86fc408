"""A run with the joint angles of another one."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, is_same
from stiffcal.mistakes.suspect_kinds import SuspectKind


class OthersAngles(RunMistake):
    """The joint angles that belong to the run are another run's."""

    name = "others-angles"
    kind = SuspectKind.MISLABELLED
    rank = 30
    of_two_runs = True

    def variants(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with each other run's angles."""
        for other in read.comparable:
            joints = read.states.joints[read.members[other]]
            if is_same(read.own.joints, joints):
                continue
            likely = (
                f'the joint angles that belong here are those of run "{read.name_of(other)}": the two are mixed up; '
                "correct the angles, or leave the run out"
            )
            yield Variant(likely, joints=joints, other=other, penalty=read.mix_up_penalty(other))
