"""Columns of a load in another order: of forces, of moments, of both, a force and a moment interchanged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import permutations, product

import numpy as np

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.deciding import CLEARLY_LESS
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, Scored, TriedOn, Way

FORCES_ALONE = "forces"
"""`InputChange.value` where the order of the moments' columns is open …"""
MOMENTS_ALONE = "moments"
"""… and where theirs alone is another."""


class WrenchColumns(InputMistake):
    """Another order of a wrench's columns."""

    name = "wrench-columns"
    part = InputPart.LOADS
    tried_on = frozenset({TriedOn.DISPLACEMENTS, TriedOn.WORK})
    code = FaultCode.WRENCH_MISMATCH
    rank = 53

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the load with its columns in another order.

        The force's columns in each other order, and the moment's in that order or as they are; the moment's alone; a
        force and a moment interchanged; all moments first. Of another number of columns than 3 or 6 there is no other
        order, of 3 that of the forces alone.
        """
        kept, columns = (0, 1, 2), read.columns
        orders = [order for order in permutations(kept) if order != kept]
        if len(columns) == 3:
            for order in orders:
                yield _way(read, (*order, 3, 4, 5))
        if len(columns) != 6:
            return
        for order in orders:
            moments = tuple(3 + k for k in order)
            yield _way(read, (*order, 3, 4, 5))
            yield _way(read, (*order, *moments))
            if np.any(read.chosen.wrench[:, 3:]):
                yield _way(read, (*kept, *moments), MOMENTS_ALONE)
        for force, moment in product(kept, (3, 4, 5)):
            exchanged = {force: moment, moment: force}
            yield _way(read, tuple(exchanged.get(k, k) for k in range(6)))
        yield _way(read, (3, 4, 5, 0, 1, 2))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = f"columns are interchanged, here or in the log: write {toml_text.pair('columns', list(change.names))}"
        if change.value == FORCES_ALONE:
            mend += ", and check whether the moments are in this order"
        return ChangeTexts("wrench.columns", f"the load's columns in the order {', '.join(change.names)}", mend)

    def as_known(self, best: Scored, tried: Sequence[Scored]) -> InputChange:
        """Return the order, marked where the moments carry too little information for theirs."""
        change = best.taken.change
        if change.value == MOMENTS_ALONE:
            return change
        for other in (one for one in tried if one.taken.change.kind == self.name):
            same = other.taken.change.names[:3] == change.names[:3] and other.taken.change != change
            if same and 1.0 - best.score >= CLEARLY_LESS * (1.0 - other.score):
                return replace(change, value=FORCES_ALONE)
        return change


def _way(read: AsRead, components: tuple[int, ...], value: str = "") -> Way:
    """Return the load with these components as its six."""
    states = replace(read.chosen, wrench=read.chosen.wrench[:, components])
    return Way(states, tuple(read.columns[k] for k in components[: len(read.columns)]), value=value)
