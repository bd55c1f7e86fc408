"""The order in which runs were measured: what is mixed up is most often what came one after the other."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates

# Files and rows are mixed up with those before and after them about as often as with all others together.
SHARE_OF_NEIGHBOURS = 0.5


@dataclass(frozen=True)
class TimeOrder:
    """Where each of R runs stands in time."""

    rank: Integers
    """(R,) from 0; by the time stamps where all runs have some of one clock, else in the order of the campaign."""
    start: Floats
    """(R,) s, the first time stamp of each run; NaN where the runs share no clock."""

    @classmethod
    def of(cls, states: LoadStates, members: Sequence[Integers]) -> TimeOrder:
        """Return the order of runs with these states; a clock that starts anew in each run gives none."""
        present = np.array([len(own) > 0 for own in members], dtype=np.bool_)
        first = np.array([np.nanmin(states.time[own]) if _has_time(states, own) else np.nan for own in members])
        last = np.array([np.nanmax(states.time[own]) if _has_time(states, own) else np.nan for own in members])
        order = np.argsort(first, kind="stable")
        has_times = bool(np.isfinite(first[present]).all()) and present.sum() > 1
        ordered = order[present[order]]
        if not has_times or (first[ordered][1:] <= last[ordered][:-1]).any():
            return cls(np.arange(len(members)), np.full(len(members), np.nan))
        rank = np.empty(len(members), dtype=np.int64)
        rank[order] = np.arange(len(members))
        return cls(rank, first)

    def mix_up_penalty(self, run: int, other: int, n_choices: int, n_things: int) -> float:
        """Return −2 log of the prior probability that a run has what belongs to another one.

        It is added to the squared misfit, which is −2 log of the likelihood.

        Parameters
        ----------
        run, other : the two runs, from 0.
        n_choices : how many runs it could be, the two neighbours in time included.
        n_things : how many things of a run could be mixed up: its angles, its loads, its places.
        """
        are_neighbours = abs(int(self.rank[run]) - int(self.rank[other])) == 1
        n_not_neighbours = max(n_choices - 2, 1)
        prior = SHARE_OF_NEIGHBOURS / 2.0 if are_neighbours else (1.0 - SHARE_OF_NEIGHBOURS) / n_not_neighbours
        return 2.0 * log(n_things / prior)

    def out_of_order(self, most: int) -> dict[int, tuple[int | None, int | None]]:
        """Return the few runs that stand elsewhere in the campaign than in time, with those before and after in time.

        Parameters
        ----------
        most : where more runs are out of order the campaign is sorted by something else, and none is returned.
        """
        timed = np.flatnonzero(np.isfinite(self.start))
        strays = sorted(set(timed.tolist()) - set(_longest_increasing(self.rank[timed], timed)))
        if not strays or len(strays) > most:
            return {}
        by_rank = {int(self.rank[run]): int(run) for run in timed}
        return {run: (by_rank.get(int(self.rank[run]) - 1), by_rank.get(int(self.rank[run]) + 1)) for run in strays}


def _has_time(states: LoadStates, own: Integers) -> bool:
    return bool(len(own)) and bool(np.isfinite(states.time[own]).any())


def _longest_increasing(values: Integers, labels: Integers) -> list[int]:
    """Return the labels of a longest increasing subsequence (patience sorting).

    Examples
    --------
    >>> _longest_increasing(np.array([0, 3, 1, 2]), np.array([10, 11, 12, 13]))
    [10, 12, 13]
    """
    ends: list[int] = []
    positions: list[int] = []
    before = np.full(len(values), -1)
    for position, value in enumerate(values.tolist()):
        pile = bisect_left(ends, value)
        if pile:
            before[position] = positions[pile - 1]
        ends[pile : pile + 1] = [value]
        positions[pile : pile + 1] = [position]
    result = []
    position = positions[-1] if positions else -1
    while position >= 0:
        result.append(int(labels[position]))
        position = int(before[position])
    return result[::-1]
