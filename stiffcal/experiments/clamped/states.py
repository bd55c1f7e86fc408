"""Clamped runs as load states: they are fitted and diagnosed like any other run.

A state is what was read in a stretch of a half sweep: motor angles and the wrench of the fixture. What the flange did
is known without an instrument: it stood still, but for the fixture's own give (physics, section 1: D = −C_fixture W).
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.experiments.clamped.faults import ONE_WAY, RunQuality
from stiffcal.experiments.clamped.readings import ClampedReadings
from stiffcal.experiments.clamped.sweeps import loop_corners
from stiffcal.measurements.set_aside import IN_USE, SetAside, SetAsideCode
from stiffcal.reduction.raw_states import RawStates

# Of fewer readings in a run nothing is known of their noise: no states are made.
LEAST_READINGS = 96
# Stretches of a half sweep to begin with, and at most: those over which angle or torque bend are split.
PIECES, MOST_PIECES = 32, 96
# A stretch with fewer readings is averaged, and is not split any further than to the second number.
ENOUGH, FEWEST = 6, 2
# Standard deviations of its sum of squares by which a stretch misses its parabola before it is split.
BENDS = 3.5
# Readings up to this distance count for the correlation of the noise.
LAGS = 8
# An angle that takes fewer than this share of distinct values is read in steps.
STEPPED = 0.5


@dataclass(frozen=True)
class _Stretch:
    """Readings of a half sweep that make one state."""

    start: int
    """First reading."""
    end: int
    """Reading after the last."""
    at_end: bool
    """True for the last stretch of a half sweep, which is read at its end: laws with a memory turn there."""


def clamped_states(
    readings: ClampedReadings,
    joint: int,
    wrench: Floats,
    temperature: Floats | None = None,
    quality: RunQuality | None = None,
) -> RawStates | None:
    """Return the states of one clamped run; None where nothing was driven to and fro.

    Stretches are split until angle and torque are parabolas in time to within the noise: where a play is crossed they
    are short, elsewhere long. The noise is the scatter about these parabolas, with its correlation and the encoder's
    step; the states carry it (``sigma.motor``, ``sigma.wrench``).

    Parameters
    ----------
    readings : of one run. joint : the moved joint, from 1.
    wrench : (n, 6) what the fixture does to the robot, sensor axes; from the motor's torque where no sensor was read.
    temperature : (n, T) where logged.
    quality : which readings cannot be used; None: all can.
    """
    n = len(readings)
    angle = readings.joints[:, joint - 1]
    load = _leading_load(wrench)
    if load is None or n < LEAST_READINGS:
        return None
    follows = load if np.cov(angle, load)[0, 1] >= 0.0 else -load
    corners = loop_corners(angle, follows)
    if len(corners) < 2:
        return None
    # the turning point itself still belongs to the half sweep that it ends
    edges = sorted({0, *(corner + 1 for corner in corners if corner > 0), n})
    both = np.stack([angle, load], axis=1)
    noise = np.maximum(_white_noise(both), [encoder_noise(angle), 1e-12 * max(float(np.ptp(load)), 1e-300)])
    stretches: list[_Stretch] = []
    for start, end in pairwise(edges):
        stretches += _split(readings.time, both, noise, start, end)
    weights = [_weights(readings.time, stretch) for stretch in stretches]
    spread = np.array([float(np.sqrt(np.sum(weight**2))) for weight in weights])
    inflation = np.sqrt([_correlation(readings.time, both[:, k], stretches) for k in range(2)])
    noise, wrench_noise = (
        np.maximum(own, _scatter(readings.time, values, stretches))
        for own, values in ((noise, both), (_white_noise(wrench), wrench))
    )
    rounding = encoder_noise(angle) / np.sqrt([len(weight) for weight in weights])
    motor_sigma = np.hypot(inflation[0] * spread * noise[0], rounding)
    wrench_sigma = inflation[1] * spread[:, None] * wrench_noise
    name = readings.runs[int(readings.run[0])].name

    def read(values: Floats) -> Floats:
        return np.stack(
            [weight @ values[stretch.start : stretch.end] for weight, stretch in zip(weights, stretches, strict=True)]
        )

    count = len(stretches)
    signals = {
        "joints": read(readings.joints),
        "wrench": read(wrench),
        "sigma.motor": motor_sigma[:, None],
        "sigma.wrench": wrench_sigma,
    }
    if temperature is not None:
        signals["temperature"] = np.stack(
            [temperature[stretch.start : stretch.end].mean(axis=0) for stretch in stretches]
        )
    return RawStates(
        run=[name] * count,
        number=np.arange(1, count + 1),
        time=read(readings.time[:, None])[:, 0],
        hold=np.full(count, np.nan),
        signals=signals,
        scatter={},
        n_readings=np.array([stretch.end - stretch.start for stretch in stretches]),
        set_aside=_set_aside(stretches, quality),
    )


def _set_aside(stretches: list[_Stretch], quality: RunQuality | None) -> list[SetAside]:
    """Return why states are not used: all of a run driven one way, and those with a reading at the end of a range."""
    if quality is None:
        return [IN_USE] * len(stretches)
    if quality.one_way:
        code = SetAsideCode.DRIVEN_ONE_WAY
        return [SetAside(code, ONE_WAY)] * len(stretches)
    saturation = quality.saturation
    if saturation is None:
        return [IN_USE] * len(stretches)
    cut_off = SetAside(
        SetAsideCode.CUT_OFF, f"{saturation.what} is at its limit of {saturation.limit:.4g} {saturation.unit}"
    )
    return [cut_off if saturation.beyond[piece.start : piece.end].any() else IN_USE for piece in stretches]


def _leading_load(wrench: Floats) -> Floats | None:
    """Return (n,) the combination of the wrench's components that moves most over its noise; None where none moves."""
    from stiffcal.experiments.clamped.sweeps import leading_component

    return leading_component(wrench) if np.isfinite(wrench).all() else None


def encoder_noise(angle: Floats) -> float:
    """Return what an encoder's step makes of an angle (n,), rad: step/√12; 0 where the log shows none."""
    values = np.unique(np.round(angle, 12))
    if values.size < 3 or values.size > STEPPED * angle.size:
        return 0.0
    return float(np.percentile(np.diff(values), 10) / np.sqrt(12.0))


def _white_noise(values: Floats) -> Floats:
    """Return (c,) standard deviation of fast noise in values (n, c): from fourth differences, whose variance is 70."""
    if len(values) < 5:
        return np.zeros(values.shape[1])
    return np.asarray(np.median(np.abs(np.diff(values, 4, axis=0)), axis=0) / (0.6745 * np.sqrt(70.0)))


def _split(time: Floats, both: Floats, noise: Floats, start: int, end: int) -> list[_Stretch]:
    """Return the stretches of a half sweep: equal ones, of which those that bend most are halved."""
    edges = np.unique(np.linspace(start, end, PIECES + 1).round().astype(np.int64))
    queue = [(-_bend(time, both, noise, int(a), int(b)), int(a), int(b)) for a, b in pairwise(edges)]
    heapq.heapify(queue)
    while queue and queue[0][0] < -BENDS and len(queue) < MOST_PIECES:
        _, a, b = heapq.heappop(queue)
        middle = (a + b) // 2
        for first, last in ((a, middle), (middle, b)):
            heapq.heappush(queue, (-_bend(time, both, noise, first, last), first, last))
    pieces = sorted((a, b) for _, a, b in queue if b > a)
    return [_Stretch(a, b, at_end=b == end) for a, b in pieces]


def _bend(time: Floats, both: Floats, noise: Floats, start: int, end: int) -> float:
    """Return by how many standard deviations a stretch misses its parabola more than noise does."""
    count = end - start
    if count < 2 * FEWEST:
        return -np.inf
    values = both[start:end]
    if count < ENOUGH:
        # of a few readings only a jump shows
        reach = np.ptp(values, axis=0) / np.maximum(noise, 1e-300)
        ramp = np.ptp(both[max(start - count, 0) : start + 1], axis=0) / np.maximum(noise, 1e-300)
        return float(np.max(reach - 2.0 * ramp)) - 6.0
    basis = _basis(time[start:end])
    remaining = values - basis @ (basis.T @ values)
    dof = count - basis.shape[1]
    excess = np.sum(remaining**2, axis=0) / np.maximum(noise, 1e-300) ** 2 - dof
    return float(np.max(excess) / np.sqrt(2.0 * dof))


def _basis(time: Floats) -> Floats:
    """Return (n, 3) orthonormal columns that span the parabolas over times (n,)."""
    centred = time - time.mean()
    scale = float(np.abs(centred).max()) or 1.0
    return np.asarray(np.linalg.qr((centred / scale)[:, None] ** np.arange(3))[0])


def _weights(time: Floats, stretch: _Stretch) -> Floats:
    """Return (k,) weights with which a stretch's readings make its state: of a parabola, at its middle or its end."""
    count = stretch.end - stretch.start
    if count < ENOUGH:
        return np.full(count, 1.0 / count)
    within = time[stretch.start : stretch.end]
    at = within[-1] if stretch.at_end else 0.5 * (within[0] + within[-1])
    centred = within - at
    scale = float(np.abs(centred).max()) or 1.0
    q, r = np.linalg.qr((centred / scale)[:, None] ** np.arange(3))
    # the value at the point is the first coefficient: e₀ᵀ R⁻¹ Qᵀ
    return np.asarray(q @ np.linalg.solve(r.T, [1.0, 0.0, 0.0]))


def _scatter(time: Floats, values: Floats, stretches: list[_Stretch]) -> Floats:
    """Return (c,) standard deviation of values (n, c) about the parabolas of all long stretches; zero without one.

    Fast noise alone is too small where a slower log was brought to the times of a faster one.
    """
    squares, dof = np.zeros(values.shape[1]), 0.0
    for stretch in stretches:
        if stretch.end - stretch.start < 2 * LAGS:
            continue
        basis = _basis(time[stretch.start : stretch.end])
        own = values[stretch.start : stretch.end]
        squares += np.sum((own - basis @ (basis.T @ own)) ** 2, axis=0)
        dof += stretch.end - stretch.start - 3.0
    return np.sqrt(squares / dof) if dof else squares


def _correlation(time: Floats, values: Floats, stretches: list[_Stretch]) -> float:
    """Return by what factor the correlation of neighbours raises the variance of a mean; at least 1."""
    products, squares, lost = np.zeros(LAGS), 0.0, 0.0
    pairs: Integers = np.zeros(LAGS, dtype=np.int64)
    for stretch in stretches:
        if stretch.end - stretch.start < 2 * LAGS:
            continue
        basis = _basis(time[stretch.start : stretch.end])
        own = values[stretch.start : stretch.end]
        remaining = own - basis @ (basis.T @ own)
        squares += float(remaining @ remaining)
        lost += 3.0
        for lag in range(1, LAGS + 1):
            products[lag - 1] += float(remaining[lag:] @ remaining[:-lag])
            pairs[lag - 1] += len(remaining) - lag
    count = float(pairs[0]) if pairs[0] else 0.0
    if squares <= 0.0 or count < 100.0:
        return 1.0
    correlation = products / squares
    # what the parabolas take away makes neighbours look opposed, by the share of the freedom that they use
    correlation += lost / max(count, 1.0)
    significant = correlation > 3.0 / np.sqrt(count)
    reach = LAGS if significant.all() else int(np.argmin(significant))
    return float(1.0 + 2.0 * np.sum(correlation[:reach]))
