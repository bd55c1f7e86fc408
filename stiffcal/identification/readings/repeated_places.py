"""Rows of absolute places in which the robot stood alike: their scatter is the noise where none is stated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.identification.readings.observations import Observations
from stiffcal.measurements.load_states import members_of
from stiffcal.mechanics.like_poses import pose_groups

# Two rows so close differ by a millimetre or two at the target, which any model of the robot predicts to a hundredth of
# that.
SAME_PLACE = float(np.radians(0.1))


def repeated_places(data: Observations) -> Iterator[Integers]:
    """Yield positions of rows that repeat each other: joints within 0.1°, the same load.

    Rows that are equal to the last digit are copies, of which one counts: copies do not scatter.

    Parameters
    ----------
    data : observations of absolute places alone.
    """
    like = pose_groups(data.angles.T, SAME_PLACE)
    _, alike = np.unique(np.column_stack([like, data.wrench.T]), axis=0, return_inverse=True)
    for group in members_of(alike.reshape(-1)):
        _, first = np.unique(np.concatenate([data.angles, data.measured])[:, group], axis=1, return_index=True)
        if len(first) > 1:
            yield group[np.sort(first)]
