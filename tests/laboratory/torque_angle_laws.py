"""Torque-angle laws of the clamped robot's six joints (004, Table 2), and readings of sweeps along them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.clamped.loops.branches import Branches, average_branches
from stiffcal.kinds.clamped.loops.torque_angle import TorqueAngleLaw

DEGREE = np.pi / 180.0
# Joint: backlash °, p3, p2, p1 over degrees in 10³ N·m (004, Table 2), and noise of a torque reading, N·m.
TABLE_2 = {
    1: (0.10, 28.7, -10.9, 1.30, 0.5),
    2: (0.15, -42.5, -5.30, 6.35, 1.0),
    3: (0.10, -8.72, -3.14, 1.47, 0.5),
    4: (0.16, 0.304, 0.00706, 0.0225, 0.03),
    5: (0.14, 8.04, -0.921, 0.285, 0.2),
    6: (0.10, 19.9, 0.598, 0.331, 0.2),
}
ENCODER = 0.0005 * DEGREE


def clamped_law(joint: int, **changed: float) -> tuple[TorqueAngleLaw, float]:
    play, p3, p2, p1, noise = TABLE_2[joint]
    curve = (1e3 * p1 / DEGREE, 1e3 * p2 / DEGREE**2, 1e3 * p3 / DEGREE**3)
    # the printed cubic of joint 1 turns over at 0.096°
    reach = (-0.1 * DEGREE, (0.095 if joint == 1 else 0.1) * DEGREE)
    law = TorqueAngleLaw(0.01 * DEGREE, play * DEGREE, 2e-3 * curve[0] * 0.1 * DEGREE, 0.0, 0.0, 0.0, curve, reach)
    return replace(law, **changed), noise  # type: ignore[arg-type]


def sweep(law: TorqueAngleLaw, noise: float, seed: int = 1, cycles: int = 3, n: int = 300) -> tuple[Floats, ...]:
    """Return angle, torque, half sweep and direction, as an encoder and a force sensor give them n times a sweep."""
    rng = np.random.default_rng(seed)
    half = 0.5 * law.width
    low, high = law.middle - half + law.reach[0], law.middle + half + law.reach[1]
    turns = np.array([low, high] * cycles + [low])
    angle = np.interp(np.arange(2 * cycles * n), np.arange(turns.size) * n, turns)
    number = np.arange(angle.size) // n
    up = number % 2 == 0
    torque = law.torque_at(angle, up) + noise * rng.standard_normal(angle.size)
    read = np.round((angle + 0.3 * ENCODER * rng.standard_normal(angle.size)) / ENCODER) * ENCODER
    return read, torque, number.astype(np.float64), up.astype(np.float64)


def branches(law: TorqueAngleLaw, noise: float, seed: int = 1, n: int = 300) -> Branches:
    angle, torque, number, up = sweep(law, noise, seed, n=n)
    return average_branches(angle, torque, number.astype(np.int64), up.astype(np.bool_), 120)
