"""Errors of a load that many states share: of a sensor's zero, and those that a law with memory keeps.

A sensor's zero is known as well as the reading with which it was zeroed, and all states of the run share that error.
Where readings follow the load in a straight line, the run's free constant takes it; next to a play they shift along a
line that is steep there and flat elsewhere, which repeats do not show and a law of the load would.

Friction holds at a turning point, and with it the error there: the play operator stays where the load turned until it
lags by the slip, and all states up to there share the error of the load at the turning point. In a sweep the load
turned between two states, which are means of readings: by as much the largest is too small.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.diagnosis.scans.geometry_nuisance import LEAST_SHOWN
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.noise.reading_noise import Noise, own_variance
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.judgement.numbers import SAME_VALUE
from stiffcal.model.laws.drives import drive_torque


class LastingError(NamedTuple):
    """An error that some states share."""

    states: Integers
    """(s,) the states."""
    makes: Floats
    """(m, s) what one standard deviation makes in their readings."""


def lasting_errors(state: Linearised, noise: Noise) -> list[LastingError]:
    """Return the errors of the load at each turning point, and of a sensor's zero.

    Parameters
    ----------
    state : the robot at rest. noise : of the readings; where none of the wrench is known, nothing lasts.
    """
    return [*_errors(state, noise), *_of_zeros(state, noise)] if noise.of_wrench else []


def made_by(errors: Sequence[LastingError], data: Observations, by_run: bool) -> tuple[Floats, Floats]:
    """Return what errors make: those of single runs, one of each in each of (k, m, n), and (q, m, n) all others.

    Parameters
    ----------
    by_run : whether those of single runs stand together; else each is one of the others.
    """
    count = Counter[int]()
    of_runs, others = list[Floats](), list[Floats]()
    for one in errors:
        column, run = np.zeros(data.measured.shape), int(data.run[one.states[0]])
        if not by_run or (data.run[one.states] != run).any():
            others.append(column)
        else:
            of_runs += [column] if count[run] == len(of_runs) else []
            column = of_runs[count[run]]
            count[run] += 1
        column[:, one.states] = one.makes
    first, last = (np.array(part).reshape(-1, *data.measured.shape) for part in (of_runs, others))
    return first, last


def _errors(state: Linearised, noise: Noise) -> Iterator[LastingError]:
    chain = state.robot.chain
    wrench = noise.of_wrenches(state.data)
    for placed in state.robot.placed:
        place = placed.place
        if not placed.has_memory or len(place.joints) != 1:
            continue
        torque = drive_torque(chain, state.loads.wrench, place.joints[0])
        size = _of_torque(torque, state.data.wrench, wrench)
        between = _between(torque, state.data)
        for term in placed.terms(chain, state.loads):
            lever = state.lever(term.node, term.component)
            if lever is None or term.symbol not in placed.values:
                continue
            slope = np.ptp(term.value) / max(float(np.ptp(torque)), 1e-300)
            for own in _stretches(np.asarray(term.value), state.data.run):
                error = np.hypot(size[own[0]], between[own[0]])
                yield LastingError(own, placed.amplitude(term.symbol) * slope * error * lever[:, own])


def _of_zeros(state: Linearised, noise: Noise) -> Iterator[LastingError]:
    data = state.data
    zeroed = np.flatnonzero(data.carries_offset)
    if not len(zeroed):
        return
    slope, size = state.tangents.reading_rows(), noise.of_wrenches(data)
    weight = np.where(data.measured_mask, 1.0 / np.sqrt(own_variance(noise, data)), 0.0)
    # a sensor that was zeroed once has one zero in all runs
    runs = [zeroed[data.run[zeroed] == run] for run in np.unique(data.run[zeroed])]
    for own in runs if data.setup.tared == "run" else [zeroed]:
        makes = slope[:, :, own] * np.median(size[:, own], axis=1)[:, None]
        bends = (makes - makes.mean(axis=2, keepdims=True)) * weight[:, None, own]
        _, values, axes = np.linalg.svd(bends.transpose(0, 2, 1).reshape(-1, 6), full_matrices=False)
        for axis in axes[values > LEAST_SHOWN]:
            yield LastingError(own, np.einsum("k,mkn->mn", axis, makes))


def _of_torque(torque: Floats, wrench: Floats, noise: Floats) -> Floats:
    """Return (n,) the standard deviation of a drive's torque, from those of force and moment (6, n)."""
    force = float(np.sqrt(np.mean(np.sum(wrench[:3] ** 2, axis=0))))
    arm = float(np.sqrt(np.mean(torque**2))) / force if force > 0.0 else 0.0
    return np.asarray(np.sqrt(np.mean(noise[3:] ** 2, axis=0) + (arm**2) * np.mean(noise[:3] ** 2, axis=0)))


def _between(torque: Floats, data: Observations) -> Floats:
    """Return (n,) the rms of how far beyond a state a sweep turned: anywhere up to half the way to the next one."""
    step = np.zeros(len(torque))
    same = np.diff(data.run) == 0
    step[1:][same] = np.abs(np.diff(torque))[same]
    swept = data.measured_mask[data.kind == MOTOR].any(axis=0)
    return np.asarray(np.where(swept, 0.5 * step / np.sqrt(3.0), 0.0))


def _stretches(value: Floats, run: Integers) -> Iterator[Integers]:
    """Give the states during which a value stays, two at least, of one run."""
    still = (np.abs(np.diff(value)) <= SAME_VALUE * np.ptp(value)) & (np.diff(run) == 0)
    edges = np.flatnonzero(~still) + 1
    for own in np.split(np.arange(len(value)), edges):
        if len(own) > 1:
            yield own
