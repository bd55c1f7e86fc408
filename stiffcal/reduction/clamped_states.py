"""Clamped runs as load states, so that they are fitted together with runs that a tracker watched.

A state is what was read in one of a few short stretches of a half sweep: motor angles and the wrench of the fixture.
What the flange did is known without an instrument: it stood still, but for the fixture's own give (physics, section 1:
D = −C_fixture W).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffcal.measurements.clamped_readings import ClampedReadings
from stiffcal.reduction.states import Gathered
from stiffcal.reduction.sweeps import cut_sweeps, leading_component

Floats = NDArray[np.float64]

# Stretches of one half sweep: enough to tell a play and a curve, few enough to average encoder steps away.
STEPS = 24
# Only the middle of a stretch is averaged: over a whole one the corner of a play would be rounded off.
WINDOW = 0.5


def clamped_states(readings: ClampedReadings, joint: int) -> Gathered | None:
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
        own = np.flatnonzero(sweeps.number == number)
        place[own] = (np.arange(own.size) + 0.5) / own.size * STEPS
    step = np.minimum(place.astype(np.int64), STEPS - 1)
    used = np.flatnonzero((sweeps.number >= 0) & (np.abs(place - step - 0.5) < 0.5 * WINDOW))
    if not used.size:
        return None
    key = sweeps.number[used] * STEPS + step[used]
    found, member = np.unique(key, return_inverse=True)
    rest = np.arange(max(3, len(readings) // 200))
    count = np.bincount(member).astype(np.float64)

    def means(values: Floats) -> Floats:
        columns = [np.bincount(member, weights=column[used]) / count for column in values.T]
        first = np.median(values[rest], axis=0)
        return np.concatenate([first[None], np.stack(columns, axis=1)])

    time = means(readings.time[:, None])[:, 0]
    n = len(found) + 1
    name = readings.runs[int(readings.run[0])].name
    return Gathered(
        run=[name] * n,
        number=np.arange(1, n + 1),
        time=time,
        hold=np.full(n, np.nan),
        signals={"joints": means(readings.joints), "wrench": means(readings.wrench)},
        scatter={},
        n_readings=np.concatenate([[rest.size], count.astype(np.int64)]),
        set_aside=[""] * n,
    )
