"""Columns of forces in another order, those of moments as well or not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import permutations

from stiffcal.escapes import toml_text
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, Scored, TriedOn, Way

FORCES_ALONE = "forces"
"""`InputChange.value` where the order of the moments' columns is open."""
# The order of the moments is known where the other one leaves a tenth more; with less, forces decide alone.
CLEARLY_LESS = 0.9


class WrenchColumns(InputMistake):
    """Another order of a wrench's columns."""

    name = "wrench-columns"
    part = InputPart.LOADS
    tried_on = frozenset({TriedOn.DISPLACEMENTS, TriedOn.WORK})
    code = FaultCode.WRENCH_MISMATCH
    rank = 53

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the load with the force's columns in each other order, and the moment's in that order or as they are.

        Of another number of columns than 3 or 6 there is no other order.
        """
        kept, columns = (0, 1, 2), read.columns
        for order in permutations(kept) if len(columns) in (3, 6) else ():
            for moments in (kept, order) if order != kept else ():
                components = (*order, *(3 + k for k in moments))
                states = replace(read.chosen, wrench=read.chosen.wrench[:, components])
                if len(columns) == 6:
                    yield Way(states, tuple(columns[k] for k in components))
                elif moments == kept:
                    yield Way(states, tuple(columns[k] for k in order))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = f"columns are interchanged, here or in the log: write {toml_text.pair('columns', list(change.names))}"
        if change.value == FORCES_ALONE:
            mend += ", and check whether the moments are in this order"
        return ChangeTexts("wrench.columns", "the force's columns in another order", mend)

    def as_known(self, best: Scored, tried: Sequence[Scored]) -> InputChange:
        """Return the order, marked where the moments carry too little information for theirs."""
        change = best.taken.change
        for other in (one for one in tried if one.taken.change.kind == self.name):
            same = other.taken.change.names[:3] == change.names[:3] and other.taken.change != change
            if same and 1.0 - best.score >= CLEARLY_LESS * (1.0 - other.score):
                return replace(change, value=FORCES_ALONE)
        return change
