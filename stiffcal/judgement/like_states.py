"""States of clamped motors' sweeps that are alike: cycle for cycle the same place, passed in the same sense.

They scatter by the noise alone, whatever the model lacks: each run's noise is known from them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import MOTOR
from stiffcal.judgement.numbers import (
    LEAST_SQUARE,
    LEAST_STATES,
    PASS,
    WORTH_OF_NEIGHBOURS,
)


@dataclass(frozen=True)
class Sweep:
    """One run of one driven motor."""

    run: int
    """Number of the run."""
    row: int
    """Number of the motor's row."""
    states: Integers
    """(s,) its states, in order."""
    passed: tuple[Integers, Integers]
    """Positions among these of the states in which the motor went forward, and back, in the order of its angle."""
    angle: Floats
    """(s,) of the motor, rad."""
    places: Floats
    """(p, s) 1 for the states of each place, 0 elsewhere."""

    def scatter(self, residual: Floats, variance: Floats) -> Floats:
        """Return squares of the noise of readings over their variance, of each against its neighbours.

        Neighbours are those in angle, of any cycles, and a reading lies on the line through them but for their noise:
        what a model leaves that is smooth over three states has no part.

        Parameters
        ----------
        residual, variance : (s,) rad and rad².
        """
        squares = []
        for own in self.passed:
            parts = [own[k : len(own) - 2 + k] for k in range(3)]
            angle, left, spread = ([values[part] for part in parts] for values in (self.angle, residual, variance))
            wide = angle[2] - angle[0]
            share = np.divide(angle[1] - angle[0], wide, out=np.full(len(wide), 0.5), where=wide > 0.0)
            off = left[1] - (1.0 - share) * left[0] - share * left[2]
            squares.append(off**2 / (spread[1] + (1.0 - share) ** 2 * spread[0] + share**2 * spread[2]))
        return np.concatenate(squares)


def variance_of(whitening: Whitening) -> Floats:
    """Return (m, n) the variance of each reading, the wrench's share included; 0 where nothing was read."""
    precision = np.einsum("aan->an", whitening.precision())
    return np.asarray(np.divide(1.0, precision, out=np.zeros_like(precision), where=precision > 0.0))


def sweeps_of(data: Observations) -> Iterator[Sweep]:
    """Give the runs in which a clamped robot's motor was driven."""
    motors, angles = np.flatnonzero(data.kind == MOTOR), data.as_read
    for run in np.unique(data.run) if len(motors) else ():
        states = np.flatnonzero(data.run == run)
        read = motors[data.measured_mask[np.ix_(motors, states)].all(axis=1)]
        if len(read) and len(states) > 1:
            row = int(read[np.argmax(np.ptp(angles[np.ix_(read, states)], axis=1))])
            angle = angles[row, states]
            passed = _passed(angle)
            yield Sweep(int(run), row, states, passed, angle, _places(passed, len(states)))


def with_noise_of_like_states(data: Observations, residual: Floats, variance: Floats) -> Observations:
    """Return readings whose runs of clamped motors have the noise by which their like states scatter.

    Parameters
    ----------
    data : m readings of n states. residual, variance : (m, n) what any model leaves of them, and of their noise.
    """
    clamped = data.clamped
    sweeps = [one for one in sweeps_of(data) if len(one.states) >= LEAST_STATES]
    if clamped is None or not sweeps:
        return data
    scatters = [one.scatter(*(values[one.row, one.states] for values in (residual, variance))) for one in sweeps]
    squares = [float(np.mean(one)) for one in scatters]
    logs = _shrunk(np.log(np.maximum(squares, LEAST_SQUARE)), np.array([len(one.states) for one in sweeps]))
    ratio = np.full(data.n_states, float(np.exp(0.5 * np.mean(logs))))
    for one, log in zip(sweeps, logs, strict=True):
        ratio[one.states] = np.exp(0.5 * log)
    return replace(data, clamped=replace(clamped, motor=clamped.motor * ratio, wrench=clamped.wrench * ratio))


def _shrunk(logs: Floats, states: Integers) -> Floats:
    """Return logarithms of runs' mean squares, as far towards their mean as chance alone makes them differ.

    A run of ν independent squares has the variance 2 / ν by chance; what the runs differ by more is theirs (DerSimonian
    and Laird 1986).
    """
    chance = 2.0 / (WORTH_OF_NEIGHBOURS * states)
    weights = 1.0 / chance
    mean = float(weights @ logs / weights.sum())
    beyond = float(weights @ (logs - mean) ** 2) - (len(logs) - 1)
    between = max(beyond / max(float(weights.sum() - weights @ weights / weights.sum()), 1e-300), 0.0)
    own = between / (between + chance)
    mean = float(np.average(logs, weights=1.0 / (between + chance)))
    return np.asarray(mean + own * (logs - mean))


def _passed(angle: Floats) -> tuple[Integers, Integers]:
    """Return the positions of states in which a motor went forward, and back, each in the order of its angle (s,)."""
    forward = np.gradient(angle) >= 0.0
    one, other = (own[np.argsort(angle[own], kind="stable")] for own in (forward.nonzero()[0], (~forward).nonzero()[0]))
    return one, other


def _places(passed: tuple[Integers, Integers], count: int) -> Floats:
    """Return (p, s) 1 for the states of each place, as many of them as there are passes, in either sense."""
    found = []
    for ordered in passed:
        sense = np.isin(np.arange(count), ordered)
        for part in np.array_split(ordered, max(round(len(ordered) / max(_passes(sense), 1)), 1)):
            if len(part):
                found.append(np.isin(np.arange(count), part))
    return np.array(found, dtype=np.float64)


def _passes(sense: Booleans) -> int:
    """Return how often (s,) states follow each other in one sense."""
    edges = np.flatnonzero(np.diff(sense)) + 1
    return sum(1 for part in np.split(sense, edges) if part[0] and len(part) >= PASS)
