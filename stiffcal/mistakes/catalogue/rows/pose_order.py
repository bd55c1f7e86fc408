"""Joint angles and places of different poses that are combined."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way

# Of so many poses the best order is looked for: the matrix of all distances takes 3 MB.
MOST_POSES = 600
# Two poses have one other order, which frames take up.
LEAST_POSES = 3
# Pairs that one line lists; the others are counted.
MOST_LISTED = 4


class PoseOrder(InputMistake):
    """The places in another order, that which meets kinematics best."""

    name = "pose-order"
    part = InputPart.ROWS
    tried_on = frozenset({TriedOn.REFERENCES})
    rank = 71

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the places in the order whose distances from kinematics have the least sum, where it is another one."""
        from scipy.optimize import linear_sum_assignment

        states, chain = read.chosen, read.chain
        if not LEAST_POSES <= len(states) <= MOST_POSES:
            return
        computed, _ = attached_poses(chain, chain.model_angles(states.joints), states.setup.targets[0])
        away = np.linalg.norm(computed[:, None] - states.position[None, :, 0], axis=2)
        _, order = linear_sum_assignment(away)
        moved = np.flatnonzero(order != np.arange(len(order)))
        if not len(moved):
            return
        names = [states.runs[run].name for run in states.run]
        pairs = tuple(name for k in moved for name in (names[k], names[order[k]]))
        yield Way(replace(states, position=states.position[order]), pairs, numbers=len(moved))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        pairs = [
            f"“{own}” has the position of “{other}”"
            for own, other in zip(change.names[::2], change.names[1::2], strict=True)
        ]
        suffix = f" and {len(pairs) - MOST_LISTED} more" if len(pairs) > MOST_LISTED else ""
        words = f"the poses in another order ({', '.join(pairs[:MOST_LISTED])}{suffix})"
        mend = "joint angles and positions of different poses are combined: use the same order of rows or files"
        return ChangeTexts("the order of the poses", words, mend)
