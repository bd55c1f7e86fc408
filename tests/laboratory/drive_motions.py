"""Free motion of a drive for tests of effects."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.model.drive_motion import DriveMotion


def strokes(speeds: tuple[float, ...], travel: float, rate: float = 50.0) -> DriveMotion:
    """Return strokes over ``travel``, rad, there and back at each speed, rad/s; no weight, no temperature."""
    velocity: list[Floats] = []
    angle: list[Floats] = []
    since: list[Floats] = []
    for speed in speeds:
        path = np.arange(0.0, travel, speed / rate)
        for direction in (1.0, -1.0):
            velocity.append(np.full(len(path), direction * speed))
            angle.append(path if direction > 0.0 else travel - path)
            since.append(path)
    n = sum(map(len, velocity))
    return DriveMotion(
        velocity=np.concatenate(velocity),
        angle=np.concatenate(angle),
        load=np.zeros(n),
        temperature=np.full(n, np.nan),
        time=np.arange(n) / rate,
        travel=np.concatenate(since),
    )
