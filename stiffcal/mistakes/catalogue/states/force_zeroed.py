"""A force sensor that was zeroed anew inside a run: loads are off by a constant from there to the run's end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.states.mistake import LeftOfStates, StateChange, StateMistake, independent
from stiffcal.mistakes.suspect_kinds import SuspectKind


class ForceZeroed(StateMistake):
    """Six numbers of a sensor's zero. In one pose a target that slipped (`seat-shift`, an effect) does the same."""

    name = "force-zeroed"
    rank = 20
    inside_a_run = True
    kind = SuspectKind.ZERO
    likely = (
        "the force sensor was zeroed anew inside the run, or the target slipped there: end the run at that state and "
        "begin another, or exclude it"
    )

    def words(self, runs: tuple[int, ...]) -> str:
        """Return in which run."""
        return f"force sensor zeroed anew in run {runs[0]}"

    def ways(self, left: LeftOfStates) -> Iterator[StateChange]:
        """Yield the zero that moves where a step explains most."""
        if left.step is None or not left.has_constants:
            return
        run = int(left.run[left.step])
        own = np.flatnonzero(left.run == run)
        after = own[own >= left.step]
        moved = np.zeros((6, *left.residual.shape))
        moved[:, :, after] = np.moveaxis(left.response[:, :, after], 1, 0)
        rows = independent(left.space.rows(moved), len(own) * len(left.residual))
        if len(rows):
            yield StateChange((run,), rows, -float(np.log(len(own))))
