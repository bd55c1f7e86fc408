"""A run with readings that are another run's."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant, is_same


class OthersReadings(RunMistake):
    """What was read of one thing belongs to another run: the likelier, the shorter after each other they were."""

    of_two_runs = True
    things: ClassVar[str]
    """What is another run's, in words."""
    mend: ClassVar[str]
    """What happened, and what to do."""

    @abstractmethod
    def readings(self, states: LoadStates) -> Mapping[str, Any]:
        """Return what would be another run's of its states, by the field of `Variant`."""

    def ways(self, read: RunRead) -> Iterator[Variant]:
        """Yield the run with each other run's readings."""
        own = self.readings(read.own)
        for other in read.comparable:
            theirs = self.readings(read.states.select(read.members[other]))
            if all(is_same(own[name], values) for name, values in theirs.items()):
                continue
            likely = f'the {self.things} that belong here are those of run "{read.name_of(other)}": {self.mend}'
            yield Variant(likely, **theirs, other=other, penalty=read.mix_up_penalty(other))
