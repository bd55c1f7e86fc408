"""Displacements with their axes in another order, or with other signs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import permutations, product

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way


class DisplacementAxes(InputMistake):
    """Other axes of the displacements."""

    name = "displacement-axes"
    part = InputPart.DISPLACEMENTS
    tried_on = frozenset({TriedOn.DISPLACEMENTS})
    code = FaultCode.WRENCH_MISMATCH
    rank = 60

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the displacements with their axes in each order, with each signs."""
        for order in permutations(range(3)):
            for signs in product((1.0, -1.0), repeat=3):
                # nothing is changed, or all of the load acts the other way
                if order == (0, 1, 2) and abs(sum(signs)) == 3.0:
                    continue
                deflection = read.chosen.deflection.copy()
                deflection[:, :, :3] = deflection[:, :, order] * np.array(signs)
                axes = tuple(f"{'-' if sign < 0.0 else ''}{'XYZ'[k]}" for k, sign in zip(order, signs, strict=True))
                yield Way(replace(read.chosen, deflection=deflection), axes)

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        words = f"the axes of the displacements as ({', '.join(change.names)})"
        return ChangeTexts("displacements", words, "correct the order and the signs of their columns, or their axes")
