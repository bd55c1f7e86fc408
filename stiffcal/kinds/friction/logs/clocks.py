"""The clock of a log of torques against that of a log of angles: what a drive needs follows how it moves.

First the lag at which torque and direction of motion agree best over all that both logs hold, by Fourier transforms;
then the one nearby at which friction, inertia and weight of each joint leave least of its torque: of all minima the
least, where the parts of the run distinguish it from the others.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.kinds.friction.logs.free_motion import smoothed
from stiffcal.reduction.clocks.lag_minima import PARTS, LagMinimum, are_distinguished, lag_minima, nearest_minimum
from stiffcal.reduction.clocks.offsets import SourceClockOffset
from stiffcal.wording import significant

MOST_POINTS = 1 << 15  # of the even grid on which both logs are compared: its work grows with them
WINDOW = 11  # of the grid's points, over which motion is smoothed before it is differentiated twice
# The best lag has to stand out from the next peak by this factor: strokes that repeat exactly leave the cycle open.
STANDS_OUT = 1.03
# Of a torque's variance, what the best lag has to explain.
LEAST_EXPLAINED = 0.3
NEARBY_S = 0.3  # around the best lag, where the misfit is scanned: a controller's delay is a tenth of it
SCAN = 0.25  # of the window over which motion is smoothed: the misfit cannot bend on a shorter scale
MOST_SCANNED = 300  # lags: the work grows with them
SETTLED_S = 1e-5  # a lag that moves by less has settled: a hundredth of the quickest controllers' step
SAME_LAG = 5.0  # standard uncertainties
LEAST_WINDOWS = 4  # of smoothing that a log needs
STANDS = 0.01  # of a joint's largest velocity: slower than this it stands, and has no direction
OF_SPACING = 0.25  # of the scan's spacing: the first step towards the minimum of one part of a run
LEAST_COMMON = 30  # readings at which both logs are compared: five for each of the six numbers of a joint
OF_STILL_TERM = 1e-9  # of the mean square: motion in one direction alone leaves terms that do not differ
UNIFORM = 12.0  # the variance of what is known to one step: step² / 12


def torque_clock(time: Floats, angle: Floats, other_time: Floats, torque: Floats) -> SourceClockOffset:
    """Return by how much the torques' clock is ahead of that of the angles.

    Parameters
    ----------
    time : (n,) s. angle : (n, c) rad, of the joints that moved. other_time : (m,) s. torque : (m, c) N·m of the same.

    Returns
    -------
    Its ``value`` is None, with the reason, where the torques do not follow the motion or fit it at several lags.
    """
    span = max(np.ptp(time), np.ptp(other_time))
    step = max(float(np.median(np.diff(time))), float(np.median(np.diff(other_time))), span / MOST_POINTS)
    even = np.arange(time[0], time[-1], step)
    away = np.arange(other_time[0], other_time[-1], step)
    if min(even.size, away.size) < LEAST_WINDOWS * WINDOW:
        return SourceClockOffset(None, None, "the logs are too short to be aligned")
    even_angle = np.stack([np.interp(even, time, column) for column in angle.T], axis=1)
    place, velocity, acceleration = smoothed(even_angle, WINDOW, step)
    even = even[WINDOW // 2 : WINDOW // 2 + velocity.shape[0]]
    standstill = STANDS * np.abs(velocity).max(axis=0)
    direction = np.where(np.abs(velocity) > standstill, np.sign(velocity), 0.0)
    needed = np.stack([np.interp(away, other_time, column) for column in torque.T], axis=1)
    coarse = _coarse(direction, needed, step)
    if coarse is None:
        return SourceClockOffset(None, None, "the torques match the motion at more than one offset: the strokes repeat")
    lag = coarse + float(away[0] - even[0])
    designs = [
        np.stack([direction[:, k], velocity[:, k], acceleration[:, k], np.cos(place[:, k]), np.sin(place[:, k]),
                  np.ones(even.size)], axis=1)
        for k in range(direction.shape[1])
    ]  # fmt: skip
    everywhere = np.ones(even.size, dtype=np.bool_)

    def misfit(inside: Booleans) -> Callable[[float], float]:
        return lambda lag: _misfit(designs, even, other_time, torque, lag, inside)

    spacing = max(SCAN * WINDOW * step, 2.0 * NEARBY_S / MOST_SCANNED)
    best, *rivals = lag_minima(misfit(everywhere), lag - NEARBY_S, lag + NEARBY_S, spacing, SETTLED_S)
    if best.loss > 1.0 - LEAST_EXPLAINED:
        return SourceClockOffset(None, None, "the torques do not follow the motion")
    if not best.inside:
        reason = (
            f"the torques match the motion best at the end of the range searched, {NEARBY_S} s from the strokes' lag"
        )
        return SourceClockOffset(None, None, reason)
    blocks = []
    for block in np.array_split(np.arange(even.size), PARTS):
        inside = np.zeros(even.size, dtype=np.bool_)
        inside[block] = True
        if all(np.ptp(design[inside, 0]) >= 2.0 for design in designs):
            blocks.append(inside)
    answers = [
        nearest_minimum(misfit(block), best.lag, OF_SPACING * spacing, NEARBY_S, SETTLED_S).lag for block in blocks
    ]
    spread = float(np.std(answers, ddof=1) / np.sqrt(len(answers))) if len(answers) > 1 else step
    # the direction of motion is known sample by sample
    spread = max(spread, float(step / np.sqrt(UNIFORM)))
    for rival in rivals:
        if abs(rival.lag - best.lag) > max(SAME_LAG * spread, 2.0 * spacing) and not _stands_out(
            best, rival, [misfit(block) for block in blocks]
        ):
            reason = (
                f"the torques match the motion as well at {significant(best.lag)} s as at {significant(rival.lag)} s"
            )
            return SourceClockOffset(None, None, reason)
    return SourceClockOffset(best.lag, spread)


def _stands_out(best: LagMinimum, rival: LagMinimum, parts: list[Callable[[float], float]]) -> bool:
    """Return whether the run's parts distinguish two lags; of fewer parts than a test needs, whether the loss does."""
    if len(parts) < PARTS:
        return rival.loss > STANDS_OUT * best.loss
    return are_distinguished([part(best.lag) for part in parts], [part(rival.lag) for part in parts])


def _coarse(way: Floats, torque: Floats, step: float) -> float | None:
    """Return the lag, s, at which torque and direction of motion agree best; None where two lags do alike."""
    torque = torque - torque.mean(axis=0)
    size = 1 << int(np.ceil(np.log2(way.shape[0] + torque.shape[0])))
    product = np.zeros(size)
    for k in range(way.shape[1]):
        scale = float(np.linalg.norm(way[:, k] - way[:, k].mean()) * np.linalg.norm(torque[:, k]))
        spectrum = np.fft.rfft(torque[:, k], size) * np.conj(np.fft.rfft(way[:, k] - way[:, k].mean(), size))
        product += np.fft.irfft(spectrum, size) / max(scale, 1e-300)
    best = int(np.argmax(product))
    away = np.abs((np.arange(size) - best + size // 2) % size - size // 2)
    falls = np.flatnonzero(product < 0.5 * product[best])
    beyond = away > (away[falls].min() if falls.size else 0)
    if beyond.any() and product[best] < STANDS_OUT * product[beyond].max():
        return None
    return (best if best < torque.shape[0] else best - size) * step


def _misfit(
    designs: list[Floats], time: Floats, other_time: Floats, torque: Floats, lag: float, inside: Booleans
) -> float:
    """Return the mean over joints of the share of the torque's variance that motion leaves unexplained."""
    shifted_time = time + lag
    common = inside & (shifted_time >= other_time[0]) & (shifted_time <= other_time[-1])
    if common.sum() < LEAST_COMMON:
        return 1.0
    shares = []
    for k, design in enumerate(designs):
        y = np.interp(shifted_time[common], other_time, torque[:, k])
        X = design[common]
        gram = X.T @ X
        answer = np.linalg.solve(gram + OF_STILL_TERM * np.trace(gram) * np.eye(len(gram)), X.T @ y)
        shares.append(float(np.mean((y - X @ answer) ** 2) / max(float(y.var()), 1e-300)))
    return float(np.mean(shares))
