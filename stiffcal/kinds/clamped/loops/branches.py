"""The branches of a torque-angle loop: half sweeps averaged over bins of angle and over cycles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers

# With fewer bins none is spared.
LEAST_BINS = 20


@dataclass(frozen=True)
class Branches:
    """Torque over angle, averaged over cycles, of one joint in one pose."""

    angle: Floats
    """(m,) rad, mean angle of the readings in a bin."""
    torque: Floats
    """(m,) N·m, mean torque of the half sweeps through that bin."""
    up: NDArray[np.bool_]
    """(m,) True where the angle was growing."""
    spread: Floats
    """(m,) N·m, standard deviation between half sweeps; NaN where one alone went through."""
    n_sweeps: Integers
    """(m,) half sweeps that went through."""
    noise: float
    """N·m, standard uncertainty of a bin's mean."""


def average_branches(angle: Floats, torque: Floats, sweep: Integers, up: NDArray[np.bool_], n_bins: int) -> Branches:
    """Average half sweeps: first each over bins of angle, then over those of one direction.

    Parameters
    ----------
    angle, torque : (n,) readings of one joint, rad, N·m.
    sweep : (n,) number of the half sweep, −1 where a reading belongs to none.
    up : (n,) direction of the half sweep.
    n_bins : bins between the smallest and the largest angle.
    """
    used = sweep >= 0
    low, high = float(angle[used].min()), float(angle[used].max())
    width = max((high - low) / n_bins, 1e-12)
    bins = np.clip(((angle - low) / width).astype(np.int64), 0, n_bins - 1)
    n_sweeps = int(sweep.max(initial=-1)) + 1
    key = (sweep * n_bins + bins)[used]
    counts = np.bincount(key, minlength=n_sweeps * n_bins).reshape(n_sweeps, n_bins)

    def means(values: Floats) -> Floats:
        sums = np.bincount(key, weights=values[used], minlength=n_sweeps * n_bins).reshape(n_sweeps, n_bins)
        return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)

    angles, torques = means(angle), means(torque)
    rising = np.zeros(n_sweeps, dtype=np.bool_)
    rising[sweep[used]] = up[used]
    directions = [
        _one_direction(angles[rising == is_rising], torques[rising == is_rising], is_rising)
        for is_rising in (True, False)
    ]
    stacked = [np.concatenate(column) for column in zip(*directions, strict=True)]
    spread, through = stacked[3], stacked[4].astype(np.int64)
    repeated = through > 1
    inside = float(np.sqrt(np.mean(spread[repeated] ** 2))) if repeated.any() else 0.0
    usual = float(np.median(through)) if through.size else 1.0
    noise = inside / np.sqrt(max(usual, 1.0))
    return Branches(stacked[0], stacked[1], stacked[2].astype(np.bool_), spread, through, noise)


def _one_direction(angle: Floats, torque: Floats, way: bool) -> tuple[Floats, ...]:
    """Return angle, torque, direction, spread and count of the bins that half sweeps of one direction went through."""
    through = np.count_nonzero(np.isfinite(torque), axis=0) if len(torque) else np.zeros(0, dtype=np.int64)
    covered = through > 0
    # At the ends the noise of the angle chooses what falls into a bin: its mean is not the mean of the curve there.
    ends: Integers = np.flatnonzero(covered)[[0, -1]] if covered.sum() > LEAST_BINS else np.zeros(0, dtype=np.int64)
    covered[ends] = False
    if not covered.any():
        return tuple(np.zeros(0) for _ in range(5))
    angle, torque, through = angle[:, covered], torque[:, covered], through[covered]
    mean = np.nanmean(torque, axis=0)
    squares = np.nansum((torque - mean) ** 2, axis=0)
    spread = np.where(through > 1, np.sqrt(squares / np.maximum(through - 1, 1)), np.nan)
    return np.nanmean(angle, axis=0), mean, np.full(through.size, float(way)), spread, through.astype(np.float64)


def reversal_error(angle: Floats, torque: Floats, sweep: Integers, up: NDArray[np.bool_]) -> float | None:
    """Return the raw width between the branches at zero torque, rad; None where one never comes there.

    Friction alone makes such a width, F/k either way. Readings count in their order of time: a joint that friction
    holds stands still while its torque crosses zero, and an average over angles would hide that.

    Parameters
    ----------
    angle, torque : (n,) rad, N·m. sweep, up : as for `average_branches`.
    """
    crossing: dict[bool, list[float]] = {True: [], False: []}
    for number in range(int(sweep.max(initial=-1)) + 1):
        of_sweep = np.flatnonzero(sweep == number)
        if of_sweep.size < 2:
            continue
        a, t = angle[of_sweep], torque[of_sweep]
        changes = np.flatnonzero(np.diff(np.signbit(t)))
        if changes.size:
            share = t[changes] / (t[changes] - t[changes + 1])
            crossing[bool(up[of_sweep[0]])].append(float(np.median(a[changes] + share * (a[changes + 1] - a[changes]))))
    if not crossing[True] or not crossing[False]:
        return None
    return float(np.mean(crossing[False]) - np.mean(crossing[True]))
