"""Quaternions with their real part last, or of the inverse orientation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.fault_changes import InputChange
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputMistake, InputPart, TriedOn, Way
from stiffcal.quaternions import quaternion_from_rotation, rotation_from_quaternion


class QuaternionOrder(InputMistake):
    """A quaternion x, y, z, w that was read as w, x, y, z."""

    name = "quaternion-order"
    part = InputPart.ORIENTATIONS
    tried_on = frozenset({TriedOn.ORIENTATIONS})
    rank = 80

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the orientations of the first target, its real part last."""
        yield _with_quaternion(read, [3, 0, 1, 2], np.ones(4))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        mend = "write the quaternion's columns with w first"
        return ChangeTexts("quaternion_wxyz", "the quaternion x, y, z, w", mend)


class QuaternionInverse(InputMistake):
    """The orientation of the instrument in the target's axes."""

    name = "quaternion-inverse"
    part = InputPart.ORIENTATIONS
    tried_on = frozenset({TriedOn.ORIENTATIONS})
    rank = 81

    def ways(self, read: AsRead) -> Iterator[Way]:
        """Yield the orientations of the first target, inverted."""
        yield _with_quaternion(read, [0, 1, 2, 3], np.array([1.0, -1.0, -1.0, -1.0]))

    def texts(self, change: InputChange, chain: Chain) -> ChangeTexts:
        """Return it in words."""
        return ChangeTexts("quaternion_wxyz", "the quaternion inverted", "invert the orientation")


def _with_quaternion(read: AsRead, order: list[int], signs: Floats) -> Way:
    """Return the poses with the components of the first target's quaternion in another order, or with other signs."""
    tracker_axes = read.chosen.base_from_tracker[:, :3, :3]
    own = quaternion_from_rotation(np.swapaxes(tracker_axes, -1, -2) @ read.chosen.rotation[:, 0])
    rotation = read.chosen.rotation.copy()
    rotation[:, 0] = tracker_axes @ rotation_from_quaternion(own[:, order] * signs)
    return Way(replace(read.chosen, rotation=rotation))
