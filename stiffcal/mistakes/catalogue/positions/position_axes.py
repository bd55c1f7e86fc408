"""Absolute places with two axes interchanged, or with another sign of one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way

AXES = "XYZ"


class PositionAxes(InputMistake):
    """Other axes of the positions of all targets, or of one.

    Of all rows and targets, all of these are one mirror but for a turn, which the estimated frame takes: `Mirrored`.
    """

    name = "position-axes"
    part = InputPart.POSITIONS
    tried_on = frozenset({TriedOn.ABSOLUTE_TABLE, TriedOn.ABSOLUTE_ROWS})
    rank = 31

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield positions with interchanged axes or another sign of one."""
        names, position = read.states.setup.target_names, read.chosen.position
        ways = [tuple({a: b, b: a}.get(axis, axis) for axis in AXES) for a, b in combinations(AXES, 2)]
        ways += [tuple(f"-{axis}" if axis == other else axis for axis in AXES) for other in AXES]
        of_all = [None] if read.tried_on is TriedOn.ABSOLUTE_ROWS else []
        for target in [*of_all, *(range(len(names)) if len(names) > 1 else ())]:
            of = "" if target is None else names[target]
            chosen = slice(None) if target is None else slice(target, target + 1)
            for axes in ways:
                columns = [AXES.index(axis[-1]) for axis in axes]
                signs = np.array([-1.0 if len(axis) > 1 else 1.0 for axis in axes])
                changed = position.copy()
                changed[:, chosen] = changed[:, chosen][..., columns] * signs
                yield Way(replace(read.chosen, position=changed), axes, value=of)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        of = f"of {change.value}" if change.value else "of the positions"
        other = [axis for axis, name in zip(AXES, change.names, strict=True) if axis != name]
        axes = " and ".join(other)
        wrong, undone = "are interchanged", "interchanged"
        if len(other) == 1:
            wrong, undone = "has the wrong sign", "with the other sign"
        mend = f"correct the columns {axes} {of}"
        return ChangeTexts(f"columns {axes} {of}", f"{axes} {of} {undone}", mend, f"{axes} {of} {wrong}")
