"""Clamped runs as load states: they are fitted and diagnosed like any other run.

A state is what was read in a stretch of a half sweep: motor angles and the wrench of the fixture. What the flange did
is known without an instrument: it stood still, but for the fixture's own give (physics, section 1: D = −C_fixture W).
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.clamped.held.faults import ONE_WAY, RunQuality
from stiffcal.kinds.clamped.logs.readings import ClampedReadings
from stiffcal.kinds.clamped.logs.sweeps import is_too_short, loop_corners
from stiffcal.kinds.clamped.states.state_noise import SeriesNoise, residual_noise, white
from stiffcal.measurements.set_aside import IN_USE, SetAside, SetAsideCode
from stiffcal.reduction.logs.blocks import noise_along_a_course
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.wording import significant

# Stretches of a half sweep to begin with: those over which angle or torque bend are split, until they are three times
# as many. Where the noise is correlated over more than a sixth of them, they are longer.
PIECES = (32, 16, 8)
CORRELATED_SHARE = 1.0 / 6.0
# Half sweeps whose numbers of readings differ by no more than this share repeat each other.
SAME_LENGTH = 0.02
# Stretches with more than this multiple of the median sum of squares bend, and show no noise.
BENT = 4.0
# A stretch with fewer readings shows no more than a jump, and is not split any further than to the second number.
ENOUGH, FEWEST = 6, 2
# A stretch with fewer readings is averaged, and so is one with a few more that curves by less than so many standard
# deviations.
LEAST_OF_PARABOLA, CURVES = 3, 2.0
# Standard deviations by which stretches miss their parabolas, in the sum of squares or in the fourth power, before they
# are split.
BENDS = 3.5
# Stretches with fewer readings show no fourth power.
LEAST_OF_QUARTIC = 8
# An angle that takes fewer than this share of distinct values is read in steps.
STEPPED = 0.5


# First reading of a stretch, and the reading after its last.
Range = tuple[int, int]


@dataclass(frozen=True)
class _Noise:
    """The noise of angle and load, as stretches that repeat each other show it."""

    series: tuple[SeriesNoise, SeriesNoise]
    """Of a single log."""
    is_stepped: bool
    """True where the angle is read in an encoder's steps, which every repeat makes alike."""

    def of_sum(self, variance: Floats, count: int) -> Floats:
        """Return (2,) the standard deviation of sums over ``count`` repeats from the sum of their variances."""
        alike = np.array([count if self.is_stepped else 1, 1])
        return np.asarray(np.sqrt(np.maximum(variance * alike, 1e-300)))


@dataclass(frozen=True)
class _Stretch:
    """Readings of a half sweep that make one state."""

    start: int
    """First reading."""
    end: int
    """Reading after the last."""
    at_end: bool
    """True where the motor turns after the last reading: it is read at its end, where laws with a memory turn."""
    is_averaged: bool
    """True where a few readings show no curvature: they are averaged."""


def clamped_states(
    readings: ClampedReadings,
    joint: int,
    wrench: Floats,
    temperature: Floats | None = None,
    quality: RunQuality | None = None,
) -> RawStates | None:
    """Return the states of one clamped run; None where nothing was driven to and fro, or hardly anything was read.

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
    if load is None:
        return None
    follows = load if np.cov(angle, load)[0, 1] >= 0.0 else -load
    corners = loop_corners(angle, follows)
    if len(corners) < 2 or is_too_short(n, len(corners)):
        return None
    # the turning point itself still belongs to the half sweep that it ends
    edges = sorted({0, *(corner + 1 for corner in corners if corner > 0), n})
    # the first and the last extreme are the largest noise of a motor at rest, not where it turned
    turns = frozenset(corner + 1 for corner in corners[1:-1])
    both = np.stack([angle, load], axis=1)
    windows = _windows(readings.time, both, edges)
    # what an encoder's steps make repeats with the cycle: differences of cycles do not hold it
    stepped = encoder_noise(angle)
    series = (
        windows.noise(angle, of_cycles=stepped == 0.0).at_least(stepped),
        windows.noise(load).at_least(1e-12 * max(float(np.ptp(load)), 1e-300)),
    )
    noise = _Noise(series, stepped > 0.0)
    stretches = _split(readings.time, both, noise, windows.pieces, edges, turns)
    weights = [_weights(readings.time, stretch) for stretch in stretches]
    bases = [_basis(readings.time[stretch.start : stretch.end]) for stretch in stretches]

    def sigma(values: Floats, of_cycles: bool = True) -> Floats:
        # noise of a slower log that was brought to the times of a faster one does not show in fast differences
        if windows.repeated and of_cycles:
            series = windows.noise(values)
        else:
            series = _residual_noise(values, stretches, bases).at_least(noise_along_a_course(values))
        return np.array([series.of_weighted(weight) for weight in weights])

    # over many readings steps are dithered; over a few they weigh as the readings do
    rounding = stepped * np.array(
        [1.0 / np.sqrt(weight.size) if weight.size >= ENOUGH else np.linalg.norm(weight) for weight in weights]
    )
    motor_sigma = np.hypot(sigma(angle, of_cycles=stepped == 0.0), rounding)
    wrench_sigma = np.stack([sigma(component) for component in wrench.T], axis=1)
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
        SetAsideCode.CUT_OFF,
        f"{saturation.what} is at its limit of {significant(saturation.limit, 4)} {saturation.unit}",
    )
    return [cut_off if saturation.beyond[piece.start : piece.end].any() else IN_USE for piece in stretches]


def _leading_load(wrench: Floats) -> Floats | None:
    """Return (n,) the combination of the wrench's components that moves most over its noise; None where none moves."""
    from stiffcal.kinds.clamped.logs.clocks import leading_component

    return leading_component(wrench) if np.isfinite(wrench).all() else None


def encoder_noise(angle: Floats) -> float:
    """Return what an encoder's step makes of an angle (n,), rad: step/√12; 0 where the log shows none."""
    values = np.unique(np.round(angle, 12))
    if values.size < 3 or values.size > STEPPED * angle.size:
        return 0.0
    return float(np.percentile(np.diff(values), 10) / np.sqrt(12.0))


@dataclass(frozen=True)
class _Windows:
    """Equal stretches of half sweeps, from which the noise is known before it is known what bends."""

    pieces: int
    """How many of them make a half sweep."""
    pairs: list[tuple[int, int, int]]
    """First reading of a window, of the same window a cycle later (or the same again where no cycle is repeated), and
    how many readings both have."""
    bases: list[Floats]
    """Of each pair (n, 3) orthonormal columns of parabolas."""
    repeated: bool
    """True where cycles are repeated: their difference holds noise and nothing that repeats, however it bends."""

    def noise(self, values: Floats, of_cycles: bool = True) -> SeriesNoise:
        """Return the noise of values (n,) about the parabolas of those windows that do not bend.

        From differences of cycles where these repeat, unless ``of_cycles`` is False.
        """
        of_cycles = self.repeated and of_cycles
        if of_cycles:
            own = [(values[b : b + n] - values[a : a + n]) / np.sqrt(2.0) for a, b, n in self.pairs]
        else:
            own = [values[a : a + n] for a, _, n in self.pairs]
        remaining = [read - basis @ (basis.T @ read) for read, basis in zip(own, self.bases, strict=True)]
        squares = np.array([np.mean(rest**2) for rest in remaining])
        straight = np.flatnonzero(squares <= BENT * np.median(squares)) if squares.size else np.zeros(0, dtype=np.int64)
        series = residual_noise([remaining[k] for k in straight], [self.bases[k] for k in straight])
        if series is None or (series.is_white and not of_cycles):
            # a parabola leaves of what bends more than fourth differences do
            return white(noise_along_a_course(values))
        return series


def _windows(time: Floats, both: Floats, edges: list[int]) -> _Windows:
    """Return windows long enough for the correlation of angle and load (n, 2)."""
    for pieces in PIECES:
        windows = _windows_of(time, edges, pieces)
        lengths = [n for _, _, n in windows.pairs]
        inflation = max(windows.noise(values).inflation for values in both.T)
        # without repeats a longer window only holds more of what bends; without windows the log is too short for them
        if not lengths or not windows.repeated or inflation <= CORRELATED_SHARE * float(np.median(lengths)):
            break
    return windows


def _windows_of(time: Floats, edges: list[int], pieces: int) -> _Windows:
    """Return the windows of a given number of equal pieces of each half sweep."""
    sweeps = [np.linspace(start, end, pieces + 1).round().astype(np.int64) for start, end in pairwise(edges)]
    lasts = np.diff(edges)
    again = [
        (own, other)
        for own, other, first, second in zip(sweeps, sweeps[2:], lasts, lasts[2:], strict=False)
        if abs(int(second) - int(first)) <= SAME_LENGTH * int(first)
    ]
    repeated = bool(again)
    pairs = [
        (int(a), int(b), int(min(a_end - a, b_end - b)))
        for own, other in (again if repeated else zip(sweeps, sweeps, strict=True))
        for (a, a_end), (b, b_end) in zip(pairwise(own), pairwise(other), strict=True)
    ]
    pairs = [pair for pair in pairs if pair[2] >= ENOUGH]
    return _Windows(pieces, pairs, [_basis(time[a : a + n]) for a, _, n in pairs], repeated)


def _residual_noise(values: Floats, stretches: list[_Stretch], bases: list[Floats]) -> SeriesNoise:
    """Return the noise of values (n,) about the parabolas of all stretches."""
    own = [values[stretch.start : stretch.end] for stretch in stretches]
    remaining = [read - basis @ (basis.T @ read) for read, basis in zip(own, bases, strict=True)]
    return residual_noise(remaining, bases) or white(noise_along_a_course(values))


def _split(
    time: Floats, both: Floats, noise: _Noise, pieces: int, edges: Sequence[int], turns: frozenset[int]
) -> list[_Stretch]:
    """Return the stretches of all half sweeps: equal ones, of which those that bend most are halved.

    Half sweeps that repeat each other are divided alike: what bends shows in their mean before it shows in one of them.

    Parameters
    ----------
    time, both : (n,) and (n, 2) angle and load. pieces : of a half sweep, to begin with.
    edges : first readings of the half sweeps, and the reading after the last. turns : those at which the motor turned.
    """
    stretches: list[_Stretch] = []
    for sweeps in _repeats(edges):
        length = min(end - start for start, end in sweeps)
        cuts = np.unique(np.linspace(0, length, pieces + 1).round().astype(np.int64))
        queue = [
            (-_bend(time, both, noise, _within(sweeps, length, int(a), int(b))), int(a), int(b))
            for a, b in pairwise(cuts)
        ]
        heapq.heapify(queue)
        while queue and queue[0][0] < -BENDS and len(queue) < 3 * pieces:
            _, a, b = heapq.heappop(queue)
            middle = (a + b) // 2
            for first, last in ((a, middle), (middle, b)):
                heapq.heappush(queue, (-_bend(time, both, noise, _within(sweeps, length, first, last)), first, last))
        for _, a, b in queue:
            ranges = _within(sweeps, length, a, b)
            averaged = _is_straight(time, both, noise, ranges)
            stretches += [_Stretch(start, end, end in turns, averaged) for start, end in ranges if end > start]
    return sorted(stretches, key=lambda stretch: stretch.start)


def _repeats(edges: Sequence[int]) -> list[list[Range]]:
    """Return the half sweeps (first reading, reading after the last), those together that repeat each other."""
    groups: list[list[Range]] = []
    for direction in (0, 1):
        of_direction: list[list[Range]] = []
        for start, end in list(pairwise(edges))[direction::2]:
            length = of_direction[-1][0][1] - of_direction[-1][0][0] if of_direction else 0
            if length and abs(end - start - length) <= SAME_LENGTH * length:
                of_direction[-1].append((start, end))
            else:
                of_direction.append([(start, end)])
        groups += of_direction
    return groups


def _within(sweeps: Sequence[Range], length: int, first: int, last: int) -> list[Range]:
    """Return a stretch of the shortest of some half sweeps, ``length`` readings long, in each of them."""
    scales = [((end - start) / length, start) for start, end in sweeps]
    return [(start + round(first * scale), start + round(last * scale)) for scale, start in scales]


def _bend(time: Floats, both: Floats, noise: _Noise, ranges: Sequence[Range]) -> float:
    """Return by how many standard deviations stretches that repeat each other bend more than a parabola does."""
    count = min(end - start for start, end in ranges)
    if count < 2 * FEWEST:
        return -np.inf
    if count < ENOUGH:
        # of a few readings only a jump shows
        single = np.maximum([series.sigma for series in noise.series], 1e-300)
        jumps = [
            np.ptp(both[start:end], axis=0) - 2.0 * np.ptp(both[max(start - count, 0) : start + 1], axis=0)
            for start, end in ranges
        ]
        return float(np.max(jumps / single)) - 6.0
    excess, variance = np.zeros(both.shape[1]), np.zeros(both.shape[1])
    quartic, of_quartic = np.zeros(both.shape[1]), np.zeros(both.shape[1])
    for start, end in ranges:
        columns = _basis(time[start:end], 5 if count >= LEAST_OF_QUARTIC else 3)
        basis = columns[:, :3]
        remaining = both[start:end] - basis @ (basis.T @ both[start:end])
        expected = np.array([series.expected_residual(basis) for series in noise.series])
        excess += np.sum(remaining**2, axis=0) - expected[:, 0]
        variance += expected[:, 1] ** 2
        if columns.shape[1] > 3:
            quartic += remaining.T @ columns[:, 4]
            of_quartic += [series.of_weighted(columns[:, 4]) ** 2 for series in noise.series]
    bends = float(np.max(excess / noise.of_sum(variance, len(ranges))))
    # the fourth power is what biases a parabola at its middle: it is looked for by itself
    return max(bends, float(np.max(np.abs(quartic) / noise.of_sum(of_quartic, len(ranges)))))


def _is_straight(time: Floats, both: Floats, noise: _Noise, ranges: Sequence[Range]) -> bool:
    """Return whether stretches of a few readings that repeat each other show no curvature."""
    count = min(end - start for start, end in ranges)
    if count >= ENOUGH:
        return False
    if count < LEAST_OF_PARABOLA:
        return True
    curved, variance = np.zeros(both.shape[1]), np.zeros(both.shape[1])
    for start, end in ranges:
        column = _basis(time[start:end])[:, 2]
        curved += both[start:end].T @ column
        variance += [series.of_weighted(column) ** 2 for series in noise.series]
    return bool(np.all(np.abs(curved) < CURVES * noise.of_sum(variance, len(ranges))))


def _basis(time: Floats, count: int = 3) -> Floats:
    """Return (n, c) orthonormal columns that span the polynomials of c coefficients, parabolas, over times (n,)."""
    centred = time - time.mean()
    scale = float(np.abs(centred).max()) or 1.0
    return np.asarray(np.linalg.qr((centred / scale)[:, None] ** np.arange(count))[0])


def _weights(time: Floats, stretch: _Stretch) -> Floats:
    """Return (k,) weights with which a stretch's readings make its state: of a parabola, at its middle or its end."""
    count = stretch.end - stretch.start
    if stretch.is_averaged:
        return np.full(count, 1.0 / count)
    within = time[stretch.start : stretch.end]
    at = within[-1] if stretch.at_end else 0.5 * (within[0] + within[-1])
    centred = within - at
    scale = float(np.abs(centred).max()) or 1.0
    q, r = np.linalg.qr((centred / scale)[:, None] ** np.arange(3))
    # the value at the point is the first coefficient: e₀ᵀ R⁻¹ Qᵀ
    return np.asarray(q @ np.linalg.solve(r.T, [1.0, 0.0, 0.0]))
