"""What a mistake in one run is, and the run's states as they would be without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.mistake import Mistake
from stiffcal.mistakes.runs.time_order import TimeOrder
from stiffcal.mistakes.suspect_kinds import SuspectKind

# Of more runs those that were measured shortly before and after are looked at: runs that are mixed up mostly lie near
# each other, and the time grows with their number.
MOST_NEIGHBOURS = 200


@dataclass(frozen=True)
class Variant:
    """A run's states with one mistake taken back."""

    likely: str
    """Cause and cure, in words."""
    factor: float | None = None
    """By what readings are multiplied; None where nothing is."""
    joints: Floats | None = None
    """Of the run's states; None where as read."""
    wrench: Floats | None = None
    """Of the run's states; None where as read."""
    position: Floats | None = None
    """Of the run's states; None where as read."""
    rotation: Floats | None = None
    """Of the run's states; None where as read."""
    deflection: Floats | None = None
    """Of the run's states; None where as read."""
    other: int | None = None
    """The run that has the readings that belong here; None where no other run takes part."""
    penalty: float = 0.0
    """How much less likely it is before any look at the numbers, as a difference of squared misfits: twice the
    logarithm of how many like mistakes there are to choose from.
    """
    kind: SuspectKind = SuspectKind.UNKNOWN
    """What the mistake was; as of its class."""


@dataclass(frozen=True)
class RunRead:
    """A run as it was read, among all runs of a campaign."""

    states: LoadStates
    """Of the whole campaign."""
    members: Sequence[Integers]
    """The states of each run."""
    run: int
    """Which one, from 0."""
    chain: Chain
    """For the names of joints."""
    left_out: Sequence[int] = ()
    """Other runs that stand apart. Where there are many runs, a run is compared with these and with those measured
    shortly before and after it.
    """

    @cached_property
    def own(self) -> LoadStates:
        """Its states."""
        return self.states.select(self.members[self.run])

    @cached_property
    def comparable(self) -> tuple[int, ...]:
        """Runs of as many states whose readings may be this run's."""
        # Of two runs that are exchanged both stand apart, so that no distance hides the other one.
        distant = {k for k in self.left_out if abs(k - self.run) > MOST_NEIGHBOURS}
        first, last = max(self.run - MOST_NEIGHBOURS, 0), min(self.run + MOST_NEIGHBOURS + 1, len(self.members))
        count = len(self.members[self.run])
        near = sorted({*range(first, last), *distant})
        return tuple(k for k in near if k != self.run and len(self.members[k]) == count)

    @cached_property
    def _order(self) -> TimeOrder:
        return TimeOrder.of(self.states, self.members)

    def mix_up_penalty(self, other: int) -> float:
        """Return the penalty of readings that are another run's: what follows each other is mixed up more often."""
        return self._order.mix_up_penalty(self.run, other, len(self.comparable), self._n_things)

    @cached_property
    def _n_things(self) -> int:
        """Of a run, how many may be another one's."""
        return sum(mistake.of_two_runs for mistake in mistakes_of(RunMistake))

    def name_of(self, other: int) -> str:
        """Return the name of another run."""
        return self.states.runs[int(self.states.run[self.members[other][0]])].name


class RunMistake(Mistake[RunRead, Variant]):
    """One mistake in all readings of a run."""

    kind: ClassVar[SuspectKind]
    """How it is answered."""
    of_two_runs: ClassVar[bool] = False
    """Whether the run has readings of another one: what that is worth follows from the order of the runs."""


def scaled(values: Floats, component: int | slice, factor: float) -> Floats:
    """Return values (..., c) with some components multiplied."""
    result = values.copy()
    result[..., component] *= factor
    return np.asarray(result)


def is_same(first: Floats, second: Floats) -> bool:
    """Return whether two runs have the same readings to the last digit."""
    return bool(np.array_equal(first, second, equal_nan=True))
