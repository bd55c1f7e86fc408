"""The engine that takes mistakes in what is read back one after another."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.fault_changes import InputChange
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.inputs.mistake import AsRead, InputMistake, TakenBack, TriedOn


def mistakes_on(tried_on: TriedOn) -> tuple[InputMistake, ...]:
    """Return the mistakes that may be there, the likelier ones first."""
    return tuple(mistake for mistake in mistakes_of(InputMistake) if tried_on in mistake.tried_on)


def taken_back(read: AsRead) -> Iterator[TakenBack]:
    """Yield data with each mistake taken back that may be in them, in all its ways, the likelier mistakes first."""
    for mistake in mistakes_on(read.tried_on):
        for way in mistake.ways(read):
            change = InputChange(mistake.name, way.names, way.sizes, way.value)
            yield TakenBack(mistake, change, way.states, way.chain or read.chain, way.numbers)
