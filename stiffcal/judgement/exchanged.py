"""Two runs of which angles, loads or places are exchanged, as happens where files or rows of a table are mixed up.

What an exchange does to the readings follows from how each pose answers a load: the column of a pair has no size of its
own. Of all pairs those that explain most are kept.

Loads of sweeps are not exchanged state by state: a sweep is cut into states where both of its logs bend, and of two
that follow one programme an exchange leaves nothing but the difference of their noise, by which either reads better.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.observation import Observations
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.like_states import sweeps_of
from stiffcal.judgement.numbers import EXCHANGES_KEPT


class ExchangedPart(Enum):
    """What is exchanged."""

    ANGLES = "angles"
    LOADS = "loads"
    PLACES = "places"


@dataclass(frozen=True)
class Exchange:
    """Two runs of which a part is exchanged."""

    part: ExchangedPart
    """What."""
    runs: tuple[int, int]
    """Their numbers."""
    column: Floats
    """(m, n) what it does to the readings."""

    @property
    def name(self) -> str:
        """In words."""
        return f"{self.part.value} of runs {self.runs[0]} and {self.runs[1]} exchanged"


def exchanges(ground: GroundOfStates) -> Iterator[Exchange]:
    """Give the pairs that explain most of what a model leaves, of each kind."""
    data = ground.space.data
    if data.absolute.all():
        return
    runs = _Runs.of(ground)
    for part in ExchangedPart:
        gain = _gains(ground, runs, part)
        for place in np.argsort(-gain, axis=None, kind="stable")[:EXCHANGES_KEPT]:
            i, j = (int(k) for k in np.unravel_index(place, gain.shape))
            if gain[i, j] > 0.0:
                column = np.zeros(data.measured.shape)
                column[:, runs.states[i]] = runs.moved(i, np.array([j]), part)[0]
                column[:, runs.states[j]] = runs.moved(j, np.array([i]), part)[0]
                yield Exchange(part, (int(runs.numbers[i]), int(runs.numbers[j])), column)


@dataclass(frozen=True)
class _Runs:
    """How the poses of runs answer loads."""

    numbers: Integers
    """(R,)."""
    states: list[Integers]
    """Of each run."""
    response: Floats
    """(R, m, 6) of the readings to a wrench as read, mean over the run."""
    swept: Booleans
    """(R,) True for those of a clamped robot's motor."""
    data: Observations
    """The observations."""

    @classmethod
    def of(cls, ground: GroundOfStates) -> _Runs:
        """Return it about a model."""
        data = ground.space.data
        numbers = np.unique(data.run[~data.absolute])
        states = [np.flatnonzero(data.run == number) for number in numbers]
        slopes = ground.state.tangents.reading_rows()
        response = np.array([slopes[:, :, own].mean(axis=2) for own in states])
        swept = np.isin(numbers, [sweep.run for sweep in sweeps_of(data)])
        return cls(numbers, states, response, swept, data)

    def moved(self, run: int, others: Integers, part: ExchangedPart) -> Floats:
        """Return (k, m, n of the run) what an exchange with others does to its readings.

        Parameters
        ----------
        run, others : places in ``numbers``; loads and places of others as long as the run.
        """
        own = self.data.wrench[:, self.states[run]]
        if part is ExchangedPart.ANGLES:
            return np.asarray((self.response[others] - self.response[run]) @ own)
        theirs = np.array([self.data.wrench[:, self.states[other]] for other in others])
        if part is ExchangedPart.LOADS:
            return np.asarray(self.response[run] @ (theirs - own))
        return np.asarray(self.response[others] @ theirs - self.response[run] @ own)


def _gains(ground: GroundOfStates, runs: _Runs, part: ExchangedPart) -> Floats:
    """Return (R, R) half the squares that the exchange of each pair explains; 0 below the diagonal, and where none."""
    scale, count = ground.space.whitening.scale, len(runs.numbers)
    length = np.array([len(own) for own in runs.states])
    along, square = np.zeros((count, count)), np.zeros((count, count))
    for i, own in enumerate(runs.states):
        state_by_state = (length == length[i]) & ~runs.swept & ~runs.swept[i]
        others = np.flatnonzero(state_by_state | (part is ExchangedPart.ANGLES))
        if not len(others):
            continue
        moved = runs.moved(i, others, part)
        if runs.data.free_offset:
            moved = moved - moved.mean(axis=2, keepdims=True)
        weight = scale[:, own] ** 2
        along[i, others] = np.einsum("kmn,mn,mn->k", moved, weight, ground.residual[:, own])
        square[i, others] = np.einsum("kmn,mn,kmn->k", moved, weight, moved)
    return np.triu(0.5 * np.maximum(along + along.T, 0.0) ** 2 / (1.0 + square + square.T), 1)
