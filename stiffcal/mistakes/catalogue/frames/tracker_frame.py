"""A tracker that stands elsewhere than its frame states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.fault_changes import InputChange
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.mistakes.inputs.mistake import Adjustment, AsRead, ChangeTexts, InputMistake, InputPart, TriedOn
from stiffcal.mistakes.words import millimetres
from stiffcal.quantity import JOINT_ANGLE
from stiffcal.wording import in_unit


class MisplacedTracker(InputMistake):
    """Another place of the tracker; fitted with each other mistake where the frame is estimated from these poses."""

    name = "tracker-frame"
    part = InputPart.FRAMES
    tried_on = frozenset({TriedOn.REFERENCES})
    rank = 90

    def adjustments(self, read: AsRead) -> Iterator[Adjustment]:
        """Yield three angles about the centre of the positions, rad, and three lengths, m, in base axes."""
        yield Adjustment((), np.zeros(6), _moved, lambda numbers: tuple(numbers.tolist()))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        turn, shift = np.array(change.sizes[:3]), change.sizes[3:]
        angle = float(np.linalg.norm(turn))
        about = ", ".join(f"{part:.2f}" for part in turn / max(angle, 1e-12))
        words = (
            f"the tracker frame rotated by {in_unit(angle, JOINT_ANGLE.usual, 2)} about ({about}) "
            f"through the centre of the "
            f"positions and moved by ({millimetres(shift)}) mm in base axes"
        )
        mend = "correct the tracker's frame, or write estimate = true there to estimate it from these poses"
        return ChangeTexts("frames.tracker", words, mend)


def _moved(states: LoadStates, numbers: Floats) -> LoadStates:
    """Return states with all positions moved as one body."""
    middle = states.position[:, 0].mean(axis=0)
    turned = (states.position - middle) @ rotation_from_vector(numbers[:3]).T
    return replace(states, position=turned + middle + numbers[3:6])
