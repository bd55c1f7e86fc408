"""Mistakes within runs: what is right is that the runs are named, and no effect for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.measurements.load_states import LoadStates
from tests.calibration.stress.drawing import Mistake
from tests.rates.faults import exchanged, moved_by

OFFSET = 0.1
"""Of the largest force, before it is scaled: what a sensor reads that was zeroed under load."""
STEP = 1e-4
"""m, before it is scaled: how far a target is knocked."""
RANGE = (0.5, 0.95)
"""Of the sensor, over the largest component of force."""


def _part(rng: np.random.Generator, own: Integers) -> Integers:
    """Return some neighbouring states of a run, neither its first nor all the others."""
    if len(own) < 4:
        return own[1:2]
    first = int(rng.integers(1, len(own) - 2))
    return own[first : int(rng.integers(first + 1, len(own)))]


def zeroed_anew(rng: np.random.Generator, states: LoadStates, times: float) -> Mistake:
    """Zero the force sensor in the middle of a run, so that it reads an offset until the run's end."""
    members = states.members()
    run = int(rng.integers(len(members)))
    own = members[run]
    after = own[int(rng.integers(1, len(own))) :]
    offset = rng.normal(size=3)
    offset *= times * OFFSET * np.abs(states.wrench[:, :3]).max() / np.linalg.norm(offset)
    wrench = states.wrench.copy()
    wrench[after, :3] += offset
    return Mistake(replace(states, wrench=wrench), (run,))


def saturated(rng: np.random.Generator, states: LoadStates, times: float) -> Mistake:
    """Cut a component of the force off at the sensor's range; it shows in the runs that go beyond."""
    component = int(rng.integers(3))
    force = states.wrench[:, component]
    limit = float(rng.uniform(*RANGE)) * np.abs(force).max()
    wrench = states.wrench.copy()
    wrench[:, component] = np.clip(force, -limit, limit)
    lost = np.bincount(states.run, weights=(wrench[:, component] - force) ** 2)
    order = np.argsort(-lost, kind="stable")
    return Mistake(replace(states, wrench=wrench), tuple(int(k) for k in order if lost[k] > 0.0))


def row_shifted(rng: np.random.Generator, states: LoadStates, times: float) -> Mistake:
    """Give each reading of a run the load of the row before."""
    members = states.members()
    run = int(rng.integers(len(members)))
    own = members[run]
    wrench = states.wrench.copy()
    wrench[own[1:]] = states.wrench[own[:-1]]
    return Mistake(replace(states, wrench=wrench), (run,))


def knocked_and_back(rng: np.random.Generator, states: LoadStates, times: float) -> Mistake:
    """Knock the target in the middle of a run, and push it back later in the run."""
    members = states.members()
    run = int(rng.integers(len(members)))
    step = rng.normal(size=3)
    step *= times * STEP / np.linalg.norm(step)
    return Mistake(moved_by(states, _part(rng, members[run]), step), (run,))


def exchanged_in_part(rng: np.random.Generator, states: LoadStates, times: float) -> Mistake | None:
    """Exchange the loads of the second half of two runs; None where no two runs are as long."""
    members = states.members()
    run = int(rng.integers(len(members)))
    others = [k for k, there in enumerate(members) if k != run and len(there) == len(members[run])]
    if not others:
        return None
    other = int(rng.choice(others))
    half = len(members[run]) // 2
    own, there = members[run][-half:], members[other][-half:]
    return Mistake(exchanged(states, own, there, ("wrench",)), (run, other))
