"""Two runs of which angles, loads or places are exchanged, as happens where files or rows of a table are mixed up.

What an exchange does to the readings follows from how each pose answers a load: the column of a pair has no size of its
own. Of all pairs those that explain most are kept.

Loads of sweeps are not exchanged state by state: a sweep is cut into states where both of its logs bend, and of two
that follow one programme an exchange leaves nothing but the difference of their noise, by which either reads better.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.states.mistake import LeftOfStates, StateChange, StateMistake

EXCHANGES_KEPT = 3
"""Pairs of exchanged runs of each kind that are compared with all else; a number of the computation, which
`python -m tests.calibration numbers` doubles."""


@dataclass(frozen=True)
class RunResponses:
    """How the poses of runs answer loads."""

    numbers: Integers
    """(R,)."""
    states: list[Integers]
    """Of each run."""
    response: Floats
    """(R, m, 6) of the readings to a wrench as read, mean over the run."""
    swept: Booleans
    """(R,) True for those of a clamped robot's motor."""
    wrench: Floats
    """(6, n) as read."""

    @classmethod
    def of(cls, left: LeftOfStates) -> RunResponses:
        """Return it of all runs of displacements."""
        numbers = np.unique(left.run[~left.absolute])
        states = [np.flatnonzero(left.run == number) for number in numbers]
        response = np.array([left.response[:, :, own].mean(axis=2) for own in states])
        return cls(numbers, states, response, np.isin(numbers, sorted(left.swept)), left.wrench)

    def loads(self, run: int) -> Floats:
        """Return (6, n of the run) its loads."""
        return self.wrench[:, self.states[run]]

    def loads_of(self, others: Integers) -> Floats:
        """Return (k, 6, n of each) the loads of runs of one length."""
        loads, _ = self._of_length[len(self.states[others[0]])]
        return np.asarray(loads[self._place[others]])

    def answers_of(self, others: Integers) -> Floats:
        """Return (k, m, n of each) what the poses of runs of one length make of their loads."""
        _, answers = self._of_length[len(self.states[others[0]])]
        return np.asarray(answers[self._place[others]])

    @cached_property
    def _of_length(self) -> dict[int, tuple[Floats, Floats]]:
        """By length the loads (k, 6, n) and answers (k, m, n) of its runs: each run asks for all others'."""
        found = {}
        for length, own in self._runs.items():
            loads = np.array([self.loads(k) for k in own])
            found[length] = loads, self.response[own] @ loads
        return found

    @cached_property
    def _place(self) -> Integers:
        """(R,) the place of each run among those of its length."""
        place = np.empty(len(self.states), dtype=np.int64)
        for own in self._runs.values():
            place[own] = np.arange(len(own))
        return place

    @cached_property
    def _runs(self) -> dict[int, list[int]]:
        """By length the runs."""
        runs: dict[int, list[int]] = {}
        for k, own in enumerate(self.states):
            runs.setdefault(len(own), []).append(k)
        return runs


class Exchange(StateMistake):
    """Two runs of which one part is exchanged; a file of `catalogue/states/` for each part."""

    part: ClassVar[str]
    """What is exchanged, in words."""
    of_one_length: ClassVar[bool] = True
    """Whether it takes two runs of as many states."""
    size_is_known = True

    @abstractmethod
    def moved(self, runs: RunResponses, run: int, others: Integers) -> Floats:
        """Return (k, m, n of the run) what an exchange with others does to its readings.

        Parameters
        ----------
        run, others : places in ``runs.numbers``; others as long as the run where that is asked.
        """

    def words(self, runs: tuple[int, ...]) -> str:
        """Return what was exchanged between two runs."""
        return f"{self.part} of runs {runs[0]} and {runs[1]} exchanged"

    def ways(self, left: LeftOfStates) -> Iterator[StateChange]:
        """Yield the pairs that explain most: a run with any of the others, in any part, is as likely as a run off."""
        if left.absolute.all():
            return
        runs = RunResponses.of(left)
        n_parts = len(mistakes_of(Exchange))
        gain, share = self._gains(left, runs), -float(np.log(n_parts * max(left.n_runs - 1, 1)))
        for place in np.argsort(-gain, axis=None, kind="stable")[:EXCHANGES_KEPT]:
            i, j = (int(k) for k in np.unravel_index(place, gain.shape))
            if gain[i, j] > 0.0:
                column = np.zeros(left.residual.shape)
                column[:, runs.states[i]] = self.moved(runs, i, np.array([j]))[0]
                column[:, runs.states[j]] = self.moved(runs, j, np.array([i]))[0]
                pair = int(runs.numbers[i]), int(runs.numbers[j])
                yield StateChange(pair, left.space.rows(column[None]), share)

    def _gains(self, left: LeftOfStates, runs: RunResponses) -> Floats:
        """Return (R, R) half the squares that the exchange of each pair explains; 0 below the diagonal."""
        count = len(runs.numbers)
        length = np.array([len(own) for own in runs.states])
        along, square = np.zeros((count, count)), np.zeros((count, count))
        for i, own in enumerate(runs.states):
            state_by_state = (length == length[i]) & ~runs.swept & ~runs.swept[i]
            others = np.flatnonzero(state_by_state | (not self.of_one_length))
            if not len(others):
                continue
            moved = self.moved(runs, i, others)
            if left.has_constants:
                moved = moved - moved.mean(axis=2, keepdims=True)
            weight = left.scale[:, own] ** 2
            along[i, others] = np.einsum("kmn,mn,mn->k", moved, weight, left.residual[:, own])
            square[i, others] = np.einsum("kmn,mn,kmn->k", moved, weight, moved)
        return np.triu(0.5 * np.maximum(along + along.T, 0.0) ** 2 / (1.0 + square + square.T), 1)
