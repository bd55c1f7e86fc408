"""A force sensor whose zero moved within a run: it was reset there, or it drifted.

Differences to the run's reference are then wrong by what the zero moved. It shows in what the sensor reads whenever
the load is taken off: these readings have to agree within their noise, those of the moments as well where the forces
do. The motion of the robot is not consulted, as play and friction keep an unloaded robot from its first place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mistakes.force_zero.large_steps import large_steps, with_returns_between
from stiffcal.mistakes.force_zero.moved_zero import (
    CLEARLY,
    LEAST_CLEAR_STEP,
    LEAST_STEP,
    MovedZero,
    Part,
    Unloaded,
    ZeroChange,
    unloaded_of,
)
from stiffcal.reduction.loads.cycles import UNLOADED_SHARE

# |Δ| of two readings of three components of unit noise has the median √2 · 1.538 (that of χ with three degrees).
MEDIAN_OF_DIFFERENCES = 1.538 * np.sqrt(2.0)


def moved_zeros(states: LoadStates) -> list[list[MovedZero]]:
    """Return, for each run in which the force sensor's zero seems to have moved, the accounts of it.

    A load that the rig left on looks the same in the forces alone.

    Parameters
    ----------
    states : load states that are used, of load runs.
    """
    if states.setup.load_is_weight or not len(states):
        return []
    runs = [run for run in (unloaded_of(states, members) for members in members_of(states.run)) if run is not None]
    largest = max((run.largest for run in runs), default=0.0)
    runs = [run for run in runs if run.largest > UNLOADED_SHARE * largest]
    by_part = [_accounts_of_runs(states, runs, part) for part in Part]
    # a load that is left on shows in the moments too: they are asked where the forces agree
    found = [of_force or of_moment for of_force, of_moment in zip(*by_part, strict=True)]
    return [accounts for accounts in found if accounts]


def _accounts_of_runs(states: LoadStates, runs: Sequence[Unloaded], part: Part) -> list[list[MovedZero]]:
    """Return the accounts of each run; none where its readings agree, or nothing shows their noise."""
    scatters = _scatters(runs, part)
    known = [scatter for scatter in scatters if scatter is not None]
    usual = float(np.median(known)) if known else None
    floors = [
        [value for value in (own, usual, of_sensor) if value is not None]
        for own, of_sensor in zip(scatters, _noise_of_sensor(states, runs, part), strict=True)
    ]
    shown = [k for k, values in enumerate(floors) if values]
    found: list[list[MovedZero]] = [[] for _ in runs]
    accounts = _accounts(states, [runs[k] for k in shown], [max(floors[k]) for k in shown], part)
    for k, own_accounts in zip(shown, accounts, strict=True):
        found[k] = own_accounts
    return found


def without_zeros(states: LoadStates, moved: Sequence[MovedZero]) -> LoadStates:
    """Return the states with what the zeros moved taken off the readings."""
    wrench = states.wrench.copy()
    for run in moved:
        wrench[run.members] -= run.zero
    return replace(states, wrench=wrench)


def _accounts(
    states: LoadStates, runs: Sequence[Unloaded], scatters: Sequence[float], part: Part
) -> list[list[MovedZero]]:
    """Return the accounts of what the sensor reads in runs whenever the load is taken off; none where that agrees."""
    found: list[list[MovedZero]] = [
        [account for account in (_moved(states, run, scatter, part),) if account is not None]
        for run, scatter in zip(runs, scatters, strict=True)
    ]
    if part is Part.FORCE:  # of the moments the forces say when the load is off
        with_returns, large = with_returns_between(runs), large_steps(states, runs, scatters)
        for accounts, readings, scatter, steps in zip(found, with_returns, scatters, large, strict=True):
            moved = None if readings is None else _moved(states, readings, scatter, part)
            accounts += [account for account in (moved, *steps) if account is not None]
    return found


def _scatters(runs: Sequence[Unloaded], part: Part) -> list[float | None]:
    """Return of each run the scatter of one component of the unloaded readings about their best account.

    None: there are too few readings, or the part reads nothing.
    """
    found: list[float | None] = [None] * len(runs)
    of_count: dict[int, list[int]] = {}
    for k, run in enumerate(runs):
        if run.places.size >= 3 and run.largest_of(part) > 0.0:
            of_count.setdefault(run.places.size, []).append(k)
    for numbers in of_count.values():
        readings = np.stack([runs[k].readings(part) for k in numbers])
        at = np.stack([runs[k].time[runs[k].places] for k in numbers])
        between = np.median(np.sqrt((np.diff(readings, axis=1) ** 2).sum(axis=2)), axis=1) / MEDIAN_OF_DIFFERENCES
        least = np.minimum(np.minimum(_step_of(readings)[2], _line_of(at, readings)[1]), between)
        for k, scatter in zip(numbers, least.tolist(), strict=True):
            found[k] = scatter
    return found


def _noise_of_sensor(states: LoadStates, runs: Sequence[Unloaded], part: Part) -> list[float | None]:
    """Return of each run the noise of a reading as the manifest states it or the log shows it; None: neither does."""
    sigma = states.setup.sigma
    stated = (sigma.force if part is Part.FORCE else sigma.moment) or 0.0
    if not runs:
        return []
    members = np.concatenate([run.members for run in runs])
    starts = np.cumsum([0, *(run.members.size for run in runs[:-1])])
    squares = states.wrench_scatter[members, part.columns] ** 2 / np.maximum(states.n_readings[members], 1)[:, None]
    finite = np.isfinite(squares)
    sums = np.add.reduceat(np.where(finite, squares, 0.0).sum(axis=1), starts)
    counts = np.add.reduceat(finite.sum(axis=1), starts)
    shown = np.sqrt(sums / np.maximum(counts, 1))
    return [max(own, stated) or None for own in shown.tolist()]


def _step_of(readings: Floats) -> tuple[Integers, Floats, Floats]:
    """Part readings (r, u, 3) of r runs, in order, into two groups each that scatter least.

    Returns
    -------
    Where the second group begins (r,), the step (r, 3), the scatter about both (r,).
    """
    u = readings.shape[1]
    # Σ|x − mean|² of both pieces is least where Σ|piece's sum|² / piece's count, about any point, is largest
    sums = np.cumsum(readings - readings.mean(axis=1, keepdims=True), axis=1)
    counts = np.arange(1, u)
    first, second = (sums[:, :-1] ** 2).sum(axis=2), ((sums[:, -1:] - sums[:, :-1]) ** 2).sum(axis=2)
    at = 1 + np.argmax(first / counts + second / (u - counts), axis=1)
    after = (np.arange(u) >= at[:, None])[:, :, None]
    means = [(readings * own).sum(axis=1) / own.sum(axis=1) for own in (~after, after)]
    rest = readings - np.where(after, means[1][:, None], means[0][:, None])
    return at, means[1] - means[0], np.sqrt((rest**2).sum(axis=(1, 2)) / (3 * max(u - 2, 1)))


def _line_of(time: Floats, readings: Floats) -> tuple[Floats, Floats]:
    """Return the slopes (r, c) of readings (r, u, c) over times (r, u), per s, and their scatter (r,) about these."""
    at = time - time.mean(axis=1, keepdims=True)
    slope = np.einsum("ru,ruc->rc", at, readings) / (at**2).sum(axis=1)[:, None]
    rest = readings - readings.mean(axis=1, keepdims=True) - at[:, :, None] * slope[:, None]
    free = readings.shape[2] * max(readings.shape[1] - 2, 1)
    return slope, np.sqrt((rest**2).sum(axis=(1, 2)) / free)


def _moved(states: LoadStates, run: Unloaded, scatter: float, part: Part) -> MovedZero | None:
    """Return how the zero moved in a run; None where its unloaded readings agree."""
    readings, places, time = run.readings(part), run.places, run.time
    if len(readings) < 2:
        return None
    clear = CLEARLY * scatter
    if ((readings - readings[0]) ** 2).sum(axis=1).max() < clear**2:
        return None
    (k,), _, (about_step,) = _step_of(readings[None])
    _, (about_line,) = _line_of(time[None, places], readings[None])
    first, last = int(places[0]), int(places[-1])
    # what neither a step nor a trend explains is several steps, each of which the readings around it show
    if len(readings) == 2:
        kind = ZeroChange.UNCLEAR
    elif min(about_step, about_line) > 2.0 * scatter:
        kind = ZeroChange.STEPS
    else:
        kind = ZeroChange.STEP if about_step <= about_line else ZeroChange.DRIFT
    unloaded = run.wrench[places]
    if part is Part.MOMENT:  # the forces agree
        unloaded[:, :3] = 0.0
    if kind is ZeroChange.STEP:
        change, around = unloaded[k:].mean(axis=0) - unloaded[:k].mean(axis=0), (int(places[k - 1]), int(places[k]))
        zero = np.where(np.arange(run.members.size)[:, None] < places[k], 0.0, change)
    elif kind is ZeroChange.STEPS:
        far = int(np.argmax(np.linalg.norm(readings - readings[0], axis=1)))
        change, around = unloaded[far] - unloaded[0], (first, int(places[far]))
        zero = np.stack([np.interp(time, time[places], column - column[0]) for column in unloaded.T], axis=1)
    else:
        (slope,), _ = _line_of(time[None, places], unloaded[None])
        change, around = slope * (time[last] - time[first]), (first, last)
        zero = (time - time[first])[:, None] * slope
    # a sensor drifts by itself, and a rig leaves a little of its load on; but nothing good makes one clear step
    least = LEAST_CLEAR_STEP if kind is ZeroChange.STEP else LEAST_STEP
    if np.linalg.norm(change[part.columns]) < max(least * run.largest_of(part), clear):
        return None
    between = (int(run.members[around[0]]), int(run.members[around[1]]))
    number = int(states.run[run.members[0]])
    return MovedZero(number, part, kind, between, change, len(readings), run.members, zero)
