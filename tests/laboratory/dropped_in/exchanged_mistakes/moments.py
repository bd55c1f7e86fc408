"""Two runs of which the moments alone are exchanged: a force sensor and a torque sensor with a log each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant
from stiffcal.mistakes.states.exchanges import Exchange, RunResponses
from stiffcal.mistakes.suspect_kinds import SuspectKind


class ExchangedMoments(Exchange):
    """Each has the other's moments."""

    name = "exchanged-moments"
    part = "moments"

    def moved(self, runs: RunResponses, run: int, others: Integers) -> Floats:
        """Return what others' moments do to a run's readings."""
        change = runs.loads_of(others)[:, 3:] - runs.loads(run)[3:]
        return np.asarray(runs.response[run][:, 3:] @ change)


class OthersMoments(RunMistake):
    """The moments that belong to the run are another run's."""

    name = "others-moments"
    kind = SuspectKind.EXCHANGED
    of_two_runs = True

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with each other run's moments."""
        for other in read.comparable:
            wrench = read.own.wrench.copy()
            wrench[:, 3:] = read.states.wrench[read.members[other], 3:]
            penalty = read.mix_up_penalty(other)
            yield Variant("the logs of the torques are mixed up", wrench=wrench, other=other, penalty=penalty)
