"""A made-up force log: load cycles with ramps and holds, whose holds are known."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats


def load_cycle(
    generator: np.random.Generator, rate: float = 100.0, hold: float = 2.0, ramp: float = 0.8, noise: float = 1.5,
    peak: float = 300.0, settle: float = 0.0, breaks: bool = False, lead: float = 3.0,
) -> tuple[Floats, Floats, Floats]:  # fmt: skip
    """Return time (m,), wrench (m, 6) and the true holds (h, 2) of a made-up load cycle in three directions."""
    levels = [np.zeros(3)]
    for _ in range(3):
        direction = generator.normal(size=3)
        direction /= np.linalg.norm(direction)
        for sign in (1.0, -1.0):
            levels += [sign * peak * k / 4.0 * direction for k in (1, 2, 3, 4, 3, 2, 1, 0)]
    knots, values, holds, now = [0.0, lead], [levels[0], levels[0]], [(0.0, lead)], lead
    for k, level in enumerate(levels[1:]):
        length = hold * (15.0 if breaks and k % 11 == 5 else 1.0)
        knots += [now + ramp, now + ramp + length]
        values += [level, level]
        holds.append((now + ramp, now + ramp + length))
        now += ramp + length
    time = np.arange(0.0, now + 1.0, 1.0 / rate)
    force = np.stack([np.interp(time, knots, [value[c] for value in values]) for c in range(3)], axis=1)
    if settle > 0.0:
        share = 1.0 - np.exp(-1.0 / rate / settle)
        for k in range(1, len(force)):
            force[k] = force[k - 1] + share * (force[k] - force[k - 1])
    arm = np.array([[0.0, -0.2, 0.1], [0.2, 0.0, -0.05], [-0.1, 0.05, 0.0]])
    wrench = np.concatenate([force, force @ arm.T], axis=1)
    wrench += noise * generator.normal(size=wrench.shape) * np.array([1.0, 1.0, 1.0, 0.3, 0.3, 0.3])
    return time, wrench, np.array(holds)
