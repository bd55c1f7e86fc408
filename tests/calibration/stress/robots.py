"""Kinds of robots that the field mix does not hold: other chains, axes that slide, coupled axes, other mountings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tests.laboratory.random_robots import FAMILIES, Family, Row
from tests.laboratory.track_and_arm import GANTRY as GANTRY_AXES
from tests.laboratory.track_and_arm import SCARA as SCARA_AXES
from tests.laboratory.track_and_arm import TRACK as RAIL_AXES
from tests.laboratory.track_and_arm import Row as KindRow

PALLETISER_AXES: tuple[Row, ...] = (
    # a m, alpha deg, d m, theta deg, mass kg, centre of mass m: modified DH; q3 and q4 are differences of logged angles
    (0.0, 0.0, 0.80, 0.0, 300.0, (0.10, 0.0, -0.15)),
    (0.30, -90.0, 0.0, 0.0, 160.0, (0.50, 0.0, 0.0)),
    (1.25, 0.0, 0.0, 0.0, 140.0, (0.45, 0.0, 0.0)),
    (1.35, 0.0, 0.0, 0.0, 25.0, (0.10, 0.0, 0.0)),
    (0.20, -90.0, 0.15, 0.0, 12.0, (0.0, 0.0, 0.05)),
)


def _rows(axes: Sequence[KindRow]) -> tuple[Row, ...]:
    return tuple((a, alpha, d, theta, mass, com) for a, alpha, d, theta, _, mass, com in axes)


def _sliding(axes: Sequence[KindRow]) -> tuple[int, ...]:
    return tuple(number for number, row in enumerate(axes, start=1) if row[4] == "P")


SCARA = Family(
    "scara", _rows(SCARA_AXES), 0.03, np.array([6e4, 4e4, 2.5e6, 3e3]),
    (0, 0, 0.16, 0), (110, 120, 0.11, 170), 60.0, 10e-6, 40e-6, _sliding(SCARA_AXES),
)  # fmt: skip
PALLETISER = Family(
    "palletiser", PALLETISER_AXES, 0.20, np.array([2.6, 2.4, 2.0, 0.8, 0.3]) * 1e6,
    (0, -70, 15, 90, 0), (80, 30, 25, 0, 160), 1500.0, 18e-6, 30e-6,
    coupled={
        3: {"logged": {"A3": 1.0, "A2": -1.0}, "coupling": "mechanical"},
        4: {"logged": {"A4": 1.0, "A3": -1.0}, "coupling": "mechanical"},
    },
)  # fmt: skip
RAIL = Family(
    "rail with arm", _rows(RAIL_AXES), 0.14, np.array([4e7, 1.6e6, 1.5e6, 1.2e6, 2.5e5, 2e5, 1.2e5]),
    (0.5, 0, -30, 15, 0, 0, 0), (0.5, 65, 38, 40, 110, 95, 140), 400.0, 16e-6, 30e-6, _sliding(RAIL_AXES),
)  # fmt: skip
GANTRY = Family(
    "gantry", _rows(GANTRY_AXES), 0.12, np.array([3e7, 2.5e7, 1.5e7, 2e5, 1.5e5, 1e5]),
    (0.5, 0.5, 0.5, 0, 0, 0), (0.5, 0.5, 0.4, 140, 80, 140), 400.0, 16e-6, 30e-6, _sliding(GANTRY_AXES),
)  # fmt: skip
MEDIUM = FAMILIES[1]
CEILING = replace(MEDIUM, name="ceiling", gravity=(0.0, 0.0, 9.81))
WALL = replace(MEDIUM, name="wall", gravity=(9.81, 0.0, 0.0))

BY_MUJOCO = (CEILING, WALL)
"""MuJoCo's robot has no axes that slide and no coupled drives: of the others the balance plays all."""
STRESS_ROBOTS: Mapping[str, Family] = {
    "scara": SCARA, "palletiser": PALLETISER, "rail": RAIL, "gantry": GANTRY, "ceiling": CEILING, "wall": WALL,
}  # fmt: skip
