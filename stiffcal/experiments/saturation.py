"""Limits that a torque ran into: a force sensor at the end of its range, a motor at its largest current."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.measurements.clamped_readings import ClampedReadings
from stiffcal.reduction.blocks import noise_of

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

_AXES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
# A sensor's reading that stays at the very same extreme for so many readings is cut off.
SAME = 12
# A motor's torque is at a limit where it stays at the same extreme both ways (within this share) for this share of the
# time, the joint standing still.
ALIKE = 0.03
LONG = 0.08


@dataclass(frozen=True)
class Saturation:
    """Where a torque is not what was read.

    Attributes
    ----------
    what : the channel, in words. limit : its value there, N or N·m. unit : of the limit.
    beyond : (n,) True for the readings at the limit; they are left out.
    torque : N·m about the joint from which on nothing is known.
    """

    what: str
    limit: float
    unit: str
    beyond: Booleans
    torque: float

    @property
    def sentence(self) -> str:
        """What was seen, in words."""
        share = 100.0 * float(self.beyond.mean())
        return (
            f"{self.what} stays at its limit of {self.limit:.4g} {self.unit} in {share:.0f} % of the readings: "
            f"they are left out, and nothing is known of the joint beyond {self.torque:.4g} N·m"
        )


def find_saturation(readings: ClampedReadings, angle: Floats, torque: Floats, source: str) -> Saturation | None:
    """Find the limit that one run's torque ran into, or None.

    Parameters
    ----------
    readings : of one run. angle, torque : (n,) of the moved joint. source : what tells the torque.
    """
    if source == "force sensor":
        return _of_sensor(readings.wrench, torque)
    return _of_motor(angle, torque)


def _of_sensor(wrench: Floats, torque: Floats) -> Saturation | None:
    beyond = np.zeros(len(wrench), dtype=np.bool_)
    worst = None
    for axis in range(6):
        values = wrench[:, axis]
        if np.ptp(values) <= 0.0:
            continue
        for extreme in (values.max(), values.min()):
            at = values == extreme
            if extreme != 0.0 and _longest(at) >= SAME:
                beyond |= at
                if worst is None or abs(extreme) > abs(worst[1]):
                    worst = axis, float(extreme)
    if worst is None:
        return None
    axis, limit = worst
    return Saturation(
        f"the force sensor's {_AXES[axis]}", abs(limit), "N" if axis < 3 else "N·m", beyond,
        float(np.abs(torque[~beyond]).max(initial=0.0)),
    )  # fmt: skip


def _longest(at: Booleans) -> int:
    """Return the length of the longest stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max(initial=0))


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
        mine = beyond & extreme
        if mine.mean() < max(0.5 * LONG, 4.0 * steady) or np.ptp(angle[mine]) > 0.1 * np.ptp(angle):
            return None
    return Saturation("the motor's torque", limit, "N·m", beyond, limit - slack)
