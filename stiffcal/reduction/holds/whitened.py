"""A log over its noise, whose levels are compared: what of it is noise, single readings or smooth, and what a spike."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.reduction.logs.blocks import SECOND_DIFFERENCE, noise_of

SAME_LEVEL = 0.003  # of the log's range: changes smaller than this do not cut a hold
TAILS = 0.005  # of a log's readings at each end of its range: they may be spikes
LEAST_NOISE = 1e-4  # of the largest range: stands in for the noise of a log that has none
SPIKE = 6.0  # noises from the median of its neighbours: by chance one normal reading in 5·10⁸
NEIGHBOURS = 2  # on each side, with which a spike is compared: more than half of five are sound next to two
CORNER = 5.0  # noises of a second difference: the start of a ramp, not noise
MANY_CORNERS = 0.05  # of the readings: ramps are a few readings long, and their corners are not smooth noise
SMOOTH_MEANS = (2, 4)  # readings, in whose means the noise of a filtered sensor shows
SMOOTH = (1.35, 1.5)  # times as much as single readings: white noise shows 1, means of two readings 1.9 and 2.2
MOST_SMOOTH = 8.0  # times the noise of single readings: a filter over 64 of them
LEAST_MEANS = 12  # of which a quartile is known to a half
QUARTER, FIRST_QUARTILE = 0.25, 0.3186  # of |N(0, 1)|: ramps and steps leave the smallest quarter of differences alone


def whiten(values: Floats) -> tuple[Floats, float]:
    """Return values over their noise with single spikes taken out, and the difference below which levels are one."""
    low, high = np.quantile(values, [TAILS, 1.0 - TAILS], axis=0)
    spread = high - low
    # A log without noise (a simulation, coarse digits) still has levels: its resolution stands in.
    floor = np.maximum(LEAST_NOISE * spread.max(), np.finfo(float).tiny)
    noise = np.maximum(_noise(values), floor)
    white = (values - np.median(values, axis=0)) / noise
    padded = np.pad(white, ((NEIGHBOURS, NEIGHBOURS), (0, 0)), mode="edge")
    around = np.median(np.stack([padded[k : k + len(white)] for k in range(2 * NEIGHBOURS + 1)]), axis=0)
    white = np.where(np.abs(white - around) > SPIKE, around, white)
    return white, tolerance_of(white)


def _noise(values: Floats) -> Floats:
    """Return the noise (c,) that means of several readings show, as the size of white noise that would show it.

    Filtered sensors have smooth noise, which differences of single readings hardly show. A slow log, whose ramps are a
    few readings long, looks smooth too; its corners stand out from the noise, and it is left alone.
    """
    fine = noise_of(values)
    bend = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2])
    if np.mean((bend > CORNER * np.sqrt(SECOND_DIFFERENCE) * fine).any(axis=1)) > MANY_CORNERS:
        return fine
    pairs, fours = (_noise_of_means(values, size) for size in SMOOTH_MEANS)
    noisy = fine > 0.0
    smooth = noisy.any() and all(
        np.median(means[noisy] / fine[noisy]) > least for means, least in zip((pairs, fours), SMOOTH, strict=True)
    )
    return np.asarray(np.clip(fours, fine, MOST_SMOOTH * fine)) if smooth else fine


def _noise_of_means(values: Floats, size: int) -> Floats:
    """Return the noise (c,) by means of `size` readings: from the smallest quarter of their second differences.

    Ramps and steps leave that quarter alone. Of too few readings it is 0.
    """
    n_used = len(values) // size * size
    means = values[:n_used].reshape(-1, size, values.shape[1]).mean(axis=1)
    if len(means) < LEAST_MEANS:
        return np.zeros(values.shape[1])
    bend = np.abs(means[2:] - 2.0 * means[1:-1] + means[:-2])
    return np.asarray(
        np.quantile(bend, QUARTER, axis=0) / (FIRST_QUARTILE * np.sqrt(SECOND_DIFFERENCE)) * np.sqrt(size)
    )


def tolerance_of(white: Floats) -> float:
    """Return the change of level, in units of noise, that is too small to matter or to be detected."""
    low, high = np.quantile(white, [TAILS, 1.0 - TAILS], axis=0)
    return max(SAME_LEVEL * float(np.linalg.norm(high - low)), 0.5)
