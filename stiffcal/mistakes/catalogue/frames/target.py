"""A target that is mounted elsewhere than its frame states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.fault_changes import InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import Adjustment, AsRead, ChangeTexts, InputMistake, InputPart, TriedOn
from stiffcal.mistakes.words import millimetres


class MisplacedTarget(InputMistake):
    """Another place of the first target on its body."""

    name = "target"
    part = InputPart.FRAMES
    tried_on = frozenset({TriedOn.REFERENCES})
    rank = 91

    def adjustments(self, read: AsRead) -> Iterator[Adjustment]:
        """Yield three lengths in the target's own axes, m."""
        yield Adjustment((), np.zeros(3), _moved, lambda numbers: tuple(numbers.tolist()))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        words = f"the target moved by ({millimetres(change.sizes)}) mm in its own axes"
        mend = "correct the target's frame, or write estimate = true there to estimate it from these poses"
        return ChangeTexts("frames", words, mend)


def _moved(states: LoadStates, numbers: Floats) -> LoadStates:
    """Return states with the first target moved on its body."""
    first, *others = states.setup.targets
    transform = first.transform.copy()
    transform[:3, 3] += transform[:3, :3] @ numbers
    targets = (replace(first, transform=transform), *others)
    return replace(states, setup=replace(states.setup, targets=targets))
