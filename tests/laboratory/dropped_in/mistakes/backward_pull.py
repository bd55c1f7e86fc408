"""A run whose cable pulled the other way than was entered."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.states.mistake import LeftOfStates, StateChange, StateMistake


class BackwardPull(StateMistake):
    """The load in the opposite direction in all states of one run."""

    name = "backward-pull"
    size_is_known = True

    def ways(self, left: LeftOfStates) -> Iterator[StateChange]:
        """Yield it of every run."""
        for run in np.unique(left.run):
            own = left.run == run
            moved = np.where(own, -2.0 * np.einsum("man,an->mn", left.response, left.wrench), 0.0)
            yield StateChange((int(run),), left.space.rows(moved[None]), -float(np.log(left.n_runs)))

    def words(self, runs: tuple[int, ...]) -> str:
        """Return in which run."""
        return f"run {runs[0]} pulled backwards"
