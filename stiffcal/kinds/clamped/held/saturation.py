"""Limits that a torque ran into: a force sensor at the end of its range, a motor at its largest current."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.kinds.clamped.held.chain import ClampedChain
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.reduction.logs.blocks import noise_of
from stiffcal.wording import significant

_AXES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
# A reading that stays at the very same extreme for so many readings while the joint turns is cut off.
SAME = 3
# A channel is read finely where its smallest step is below this share of its noise: at rest it never repeats by chance.
FINE = 0.2
# A motor's torque is at a limit where it stays at the same extreme both ways (within this share) for this share of the
# time, the joint standing still.
ALIKE = 0.03
LONG = 0.08


@dataclass(frozen=True)
class Saturation:
    """Where a torque is not what was read."""

    what: str
    """The channel, in words."""
    limit: float
    """Its value there, N or N·m."""
    unit: str
    """Of the limit."""
    beyond: Booleans
    """(n,) True for the readings at the limit; they are left out."""
    torque: float
    """N·m about the joint from which on nothing is known."""

    @property
    def sentence(self) -> str:
        """What was measured, in words."""
        share = 100.0 * float(self.beyond.mean())
        return (
            f"{self.what} stays at its limit of {significant(self.limit, 4)} {self.unit} in "
            f"{share:.0f} % of the readings: these "
            f"are excluded, and the joint is not identified beyond {significant(self.torque, 4)} N·m"
        )


def find_saturation(readings: ClampedReadings, angle: Floats, torque: Floats, chain: ClampedChain) -> Saturation | None:
    """Find the limit that one run's torque ran into, or None.

    Parameters
    ----------
    readings : of one run. angle, torque : (n,) of the moved joint. chain : the run in drive coordinates.
    """
    if chain.source == "force sensor":
        cut_off = _reaches_limit(readings.wrench, angle)
        if cut_off is None:
            return None
        axis, limit, beyond = cut_off
        unit = "N" if axis < 3 else "N·m"
        signal = f"the force sensor's {_AXES[axis]}"
    else:
        joint_torque = readings.torque[:, chain.joint - 1][:, None]
        cut_off = _reaches_limit(joint_torque, angle)
        if cut_off is None:
            return _of_motor(angle, torque)
        _, limit, beyond = cut_off
        unit, signal = "N·m", "the motor's torque, as logged,"
    return Saturation(signal, limit, unit, beyond, float(np.abs(torque[~beyond]).max(initial=0.0)))


def _reaches_limit(channels: Floats, angle: Floats) -> tuple[int, float, Booleans] | None:
    """Return the worst channel that is cut off, its limit and where; None where none is.

    A reading that is coarser than its noise repeats too, and at rest for long. Cut off is what repeats at the extreme
    while the joint turns on, longer than it ever does between; at rest, what repeats there alone, read finely.
    """
    beyond = np.zeros(len(channels), dtype=np.bool_)
    worst = None
    turn = np.abs(np.gradient(angle))
    moving = turn > 0.2 * float(np.percentile(turn, 80.0))
    for axis, values in enumerate(channels.T):
        if np.ptp(values) <= 0.0:
            continue
        same = np.concatenate([[False], np.diff(values) == 0.0])
        between = same & (values != values.max()) & (values != values.min())
        usual, turning = (1 + int(np.ptp(_longest(mask))) for mask in (between, between & moving))
        fine = np.diff(np.unique(values)).min() < FINE * float(noise_of(values[:, None])[0])
        for extreme in (values.max(), values.min()):
            at = values == extreme
            start, end = _longest(at)
            if extreme == 0.0 or end - start < SAME:
                continue
            turns_on = bool(moving[start:end].mean() > 0.5)
            if end - start >= 3 * turning if turns_on else usual == 1 and fine:
                beyond |= at
                if worst is None or abs(extreme) > worst[1]:
                    worst = axis, abs(float(extreme))
    return None if worst is None else (*worst, beyond)


def _longest(at: Booleans) -> tuple[int, int]:
    """Return start and end of the longest stretch of True; (0, 0) where there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(np.int8)))
    if not edges.size:
        return 0, 0
    k = int(np.argmax(edges[1::2] - edges[::2]))
    return int(edges[2 * k]), int(edges[2 * k + 1])


def _of_motor(angle: Floats, torque: Floats) -> Saturation | None:
    high, low = float(np.percentile(torque, 99.5)), float(np.percentile(torque, 0.5))
    limit = 0.5 * (high - low)
    if limit <= 0.0 or abs(high + low) > ALIKE * (high - low):
        return None
    slack = max(ALIKE * limit, 3.0 * float(noise_of(torque[:, None])[0]))
    beyond = np.abs(np.abs(torque) - limit) < slack
    beyond |= np.abs(torque) > limit
    # a torque that goes to and fro at a steady rate comes as near as this for so long, limit or not
    steady = 0.5 * slack / limit
    for extreme in (torque > 0.0, torque < 0.0):
        at_limit = beyond & extreme
        if at_limit.mean() < max(0.5 * LONG, 4.0 * steady) or np.ptp(angle[at_limit]) > 0.1 * np.ptp(angle):
            return None
    return Saturation("the motor's torque", limit, "N·m", beyond, limit - slack)
