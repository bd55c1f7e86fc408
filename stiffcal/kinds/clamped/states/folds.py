"""What is left out together of clamped runs: a run, that is a joint in one position, or where these are few a cycle."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.measurements.load_states import members_of

# With fewer positions of a joint its cycles are left out instead.
LEAST_POSITIONS = 5
# A motor's angle has turned when it goes back by this share of its span.
TURN_SHARE = 0.35


def clamped_folds(data: Observations) -> Integers:
    """Return (n,) fold numbers of states of clamped runs, from 0."""
    motors = data.rows_of(MOTOR)
    fold, following = np.zeros(data.n_states, dtype=np.int64), 0
    runs = members_of(data.run)
    # not as corrected for a model: models are compared over the same folds
    angles = [data.as_read[np.ix_(motors, members)] for members in runs]
    joints = [int(np.argmax(np.ptp(angle, axis=1))) for angle in angles]
    for members, angle, joint in zip(runs, angles, joints, strict=True):
        cycle = np.zeros(len(members), dtype=np.int64)
        if joints.count(joint) < LEAST_POSITIONS:
            cycle = cycles(angle[joint])
        fold[members] = following + cycle
        following += int(cycle.max(initial=0)) + 1
    return fold


def cycles(angle: Floats) -> Integers:
    """Return (n,) the cycle of each state of a run, from 0: two half sweeps; the way to the first turn is the first.

    Parameters
    ----------
    angle : (n,) rad, in order of time.

    Examples
    --------
    >>> cycles(np.interp(np.arange(21.0), [0, 5, 10, 15, 20], [0.0, 1.0, -1.0, 1.0, 0.0])).tolist()[::5]
    [0, 0, 1, 1, 2]
    """
    least, turns = TURN_SHARE * float(np.ptp(angle)), [0]
    low = high = 0
    rising: bool | None = None
    for k in range(1, len(angle)):
        high = k if angle[k] > angle[high] else high
        low = k if angle[k] < angle[low] else low
        if rising is not False and angle[high] - angle[k] > least:
            turns.append(high)
            rising, low = False, k
        elif rising is not True and angle[k] - angle[low] > least:
            turns.append(low)
            rising, high = True, k
    half = np.searchsorted(np.array(turns[1:]), np.arange(len(angle)), side="left")
    return np.asarray(half // 2, dtype=np.int64)
