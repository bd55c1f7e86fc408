"""A run with the places of another one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant
from stiffcal.mistakes.suspect_kinds import SuspectKind


class OthersPlaces(RunMistake):
    """The places or displacements that belong to the run are another run's."""

    name = "others-places"
    kind = SuspectKind.EXCHANGED
    rank = 32
    of_two_runs = True

    def variants(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with what was measured of each other run's target; NaN where that was set aside."""
        for other in read.comparable:
            theirs = read.states.select(read.members[other])
            used = theirs.used[:, None, None]
            likely = (
                f'the places or displacements that belong here are those of run "{read.name_of(other)}": the tracker '
                "logs are interchanged; correct the file names"
            )
            yield Variant(
                likely,
                position=np.where(used, theirs.position, np.nan),
                rotation=np.where(used[..., None], theirs.rotation, np.nan),
                deflection=np.where(used, theirs.deflection, np.nan),
                other=other,
                penalty=read.mix_up_penalty(other),
            )
