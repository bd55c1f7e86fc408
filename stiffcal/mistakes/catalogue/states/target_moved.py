"""A target that was elsewhere for a while: knocked, and put back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.mistakes.states.mistake import LeftOfStates, StateChange, StateMistake, independent
from stiffcal.mistakes.suspect_kinds import SuspectKind

INTERVALS_KEPT = 2
"""Runs in which a target moved for a while that are compared with all else."""
MOST_EDGES = 120
"""States of a run at which an interval is tried to begin and to end: a grid finer than a hundredth of a run finds the
same one, and the time grows with its square."""
LEAST_INTERVAL = 1e-9
"""Share of a run's weight that an interval has beyond the run's constant, below which it is rounding."""


class TargetMoved(StateMistake):
    """All that is read of the target is off by a constant in some states of a run that follow each other."""

    name = "target-moved"
    rank = 21
    inside_a_run = True
    kind = SuspectKind.KNOCKED
    likely = (
        "the target was elsewhere for some states of the run and came back: exclude these states, or repeat the run"
    )

    def words(self, runs: tuple[int, ...]) -> str:
        """Return in which run."""
        return f"target moved for a while in run {runs[0]}"

    def ways(self, left: LeftOfStates) -> Iterator[StateChange]:
        """Yield the intervals inside a run that explain most; runs have zeros of their own."""
        if not left.has_constants:
            return
        scale, count = left.scale, len(left.residual)
        found = []
        for run in np.unique(left.run[~left.absolute]):
            own = np.flatnonzero(left.run == run)
            edges = np.unique(np.linspace(1, len(own) - 1, min(len(own), MOST_EDGES)).astype(np.int64))
            if len(edges) < 2:
                continue
            weight = scale[:, own] ** 2
            mean = np.sum(weight * left.residual[:, own], axis=1) / np.maximum(np.sum(weight, axis=1), 1e-300)
            summed = np.cumsum(weight * (left.residual[:, own] - mean[:, None]), axis=1)[:, edges - 1]
            whole, part = np.sum(weight, axis=1), np.cumsum(weight, axis=1)[:, edges - 1]
            inside = part[:, None, :] - part[:, :, None]
            square = inside * (1.0 - inside / np.maximum(whole, 1e-300)[:, None, None])
            shows = square > LEAST_INTERVAL * whole[:, None, None]
            moved = summed[:, None, :] - summed[:, :, None]
            gain = np.triu(np.sum(np.where(shows, moved**2 / np.where(shows, square, 1.0), 0.0), axis=0), 1)
            a, b = (int(k) for k in np.unravel_index(int(np.argmax(gain)), gain.shape))
            if gain[a, b] > 0.0:
                found.append((float(gain[a, b]), int(run), own[edges[a] : edges[b]], len(own)))
        for _, run, states, length in sorted(found, key=lambda one: -one[0])[:INTERVALS_KEPT]:
            moved = np.zeros((count, *left.residual.shape))
            for component in range(count):
                median = np.median(scale[component, states])
                moved[component, component, states] = 1.0 / median if median > 0.0 else 0.0
            rows = independent(left.space.rows(moved), length * count)
            if len(rows):
                yield StateChange((run,), rows, -float(np.log(0.5 * length * (length - 1.0))))
