"""Targets of one body that are exchanged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.absolute.met_places import orders
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way
from stiffcal.mistakes.words import listed


class TargetOrder(InputMistake):
    """Another order of the targets, in some rows: in all of them the targets' offsets take it up."""

    name = "target-order"
    part = InputPart.POSITIONS
    tried_on = frozenset({TriedOn.ABSOLUTE_ROWS})
    # before the angles: half a turn of the last joint exchanges two targets that stand symmetrically
    rank = 10

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the positions of the targets in each other order."""
        names, position = read.states.setup.target_names, read.chosen.position
        for order in orders(position.shape[1]):
            moved = tuple(names[b] for b in range(len(order)) if order[b] != b)
            yield Way(replace(read.chosen, position=position[:, order]), moved)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        of = f"the positions of {listed(change.names)}"
        place = f"columns of {listed(change.names)}"
        return ChangeTexts(place, f"{of} interchanged", f"interchange {of}", f"{of} are interchanged")
