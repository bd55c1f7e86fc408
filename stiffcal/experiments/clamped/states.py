"""Clamped runs as load states, so that they are fitted together with runs that a tracker measured.

A state is what was read in one of a few short stretches of a half sweep: motor angles and the wrench of the fixture.
What the flange did is known without an instrument: it stood still, but for the fixture's own give (physics, section 1:
D = −C_fixture W).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.experiments.clamped.readings import ClampedReadings
from stiffcal.experiments.clamped.sweeps import cut_sweeps, leading_component
from stiffcal.measurements.set_aside import IN_USE
from stiffcal.reduction.raw_states import RawStates

# Stretches of one half sweep: enough to resolve a play and a curve, few enough to average encoder steps away.
STEPS = 48
# With fewer readings a stretch is averaged; with more a parabola is laid through them, and its middle is read: a mean
# would round off the corner between a play and its flank.
ENOUGH = 5


def clamped_states(readings: ClampedReadings, joint: int) -> RawStates | None:
    """Return the states of one clamped run; None where no wrench was read or no whole sweep was made.

    The first state is the rest before the sweeps, where the robot was clamped.

    Parameters
    ----------
    readings : of one run. joint : the moved joint, from 1.
    """
    force = leading_component(readings.wrench) if np.isfinite(readings.wrench).all() else None
    if force is None:
        return None
    angle = readings.joints[:, joint - 1]
    follows = force if np.cov(angle, force)[0, 1] >= 0.0 else -force
    sweeps = cut_sweeps(angle, follows)
    if sweeps.count == 0:
        return None
    # By time, not by angle: what falls into a step of angle would be chosen by the angle's own noise.
    place = np.full(len(readings), -1.0)
    for number in range(sweeps.count):
        of_sweep = np.flatnonzero(sweeps.number == number)
        # half a stretch at either end stays out: which reading is the corner of the loop, its own noise has chosen
        place[of_sweep] = (np.arange(of_sweep.size) + 0.5) / of_sweep.size * (STEPS + 1) - 0.5
    step = np.floor(place).astype(np.int64)
    used = np.flatnonzero((sweeps.number >= 0) & (step >= 0) & (step < STEPS))
    if not used.size:
        return None
    key = sweeps.number[used] * STEPS + step[used]
    poses, member = np.unique(key, return_inverse=True)
    middle = _middle_weights(place[used] - step[used] - 0.5, member)
    count = np.bincount(member)
    initial = np.arange(max(3, len(readings) // 200))

    def middles(values: Floats) -> Floats:
        columns = [np.bincount(member, weights=middle * column[used]) for column in values.T]
        first = np.median(values[initial], axis=0)
        return np.concatenate([first[None], np.stack(columns, axis=1)])

    time = middles(readings.time[:, None])[:, 0]
    n = len(poses) + 1
    name = readings.runs[int(readings.run[0])].name
    return RawStates(
        run=[name] * n,
        number=np.arange(1, n + 1),
        time=time,
        hold=np.full(n, np.nan),
        signals={"joints": middles(readings.joints), "wrench": middles(readings.wrench)},
        scatter={},
        n_readings=np.concatenate([[initial.size], count]),
        set_aside=[IN_USE] * n,
    )


def _middle_weights(place: Floats, member: NDArray[np.int64]) -> Floats:
    """Return (n,) weights with which readings make the middle of their stretch: of a parabola through them.

    Parameters
    ----------
    place : (n,) where in its stretch a reading lies, −½ … ½. member : (n,) which stretch.
    """
    sums = [np.bincount(member, weights=place**power) for power in range(5)]
    count = sums[0]
    moments = np.stack([np.stack([sums[a + b] for b in range(3)], axis=-1) for a in range(3)], axis=-2)
    few = count < ENOUGH
    moments[few] = np.eye(3)
    first = np.zeros((len(count), 3, 1))
    first[:, 0] = 1.0
    answer = np.linalg.solve(moments, first)[:, :, 0]
    answer[few] = 0.0
    answer[few, 0] = 1.0 / count[few]
    return np.asarray(np.einsum("nk,nk->n", answer[member], place[:, None] ** np.arange(3)))
