"""Robots with prismatic joints: an arm on an inclined track, a gantry with a wrist, a SCARA with its quill."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.mechanics.chain import Chain

Row = tuple[float, float, float, float, str, float, tuple[float, float, float]]
# a m, alpha deg, d m, theta deg, "P" or "R", mass kg, centre of mass m: modified DH
TRACK: tuple[Row, ...] = (
    (0.0, 110.0, 0.1, 90.0, "P", 300.0, (0.0, 0.2, 0.0)),
    (0.0, -90.0, 0.6, -90.0, "R", 120.0, (0.10, 0.0, -0.10)),
    (0.2, -90.0, 0.0, 0.0, "R", 90.0, (0.40, 0.0, 0.06)),
    (0.89, 0.0, 0.0, -90.0, "R", 100.0, (0.08, 0.15, 0.0)),
    (0.15, -90.0, 0.88, 0.0, "R", 30.0, (0.0, 0.0, -0.25)),
    (0.0, 90.0, 0.0, 0.0, "R", 12.0, (0.0, 0.02, 0.0)),
    (0.0, -90.0, 0.0, 0.0, "R", 6.0, (0.0, 0.0, 0.10)),
)
GANTRY: tuple[Row, ...] = (
    (0.0, 90.0, 0.0, 90.0, "P", 400.0, (0.0, 0.0, 0.1)),
    (0.0, 90.0, 0.2, 90.0, "P", 150.0, (0.0, 0.1, 0.0)),
    (0.1, 90.0, 0.3, 0.0, "P", 80.0, (0.0, 0.0, -0.3)),
    (0.0, 0.0, 0.2, 0.0, "R", 30.0, (0.0, 0.0, 0.05)),
    (0.0, 90.0, 0.1, 0.0, "R", 12.0, (0.02, 0.0, 0.0)),
    (0.0, -90.0, 0.1, 0.0, "R", 6.0, (0.0, 0.0, 0.05)),
)
SCARA: tuple[Row, ...] = (
    (0.0, 0.0, 0.4, 0.0, "R", 20.0, (0.15, 0.0, 0.0)),
    (0.35, 0.0, 0.0, 0.0, "R", 12.0, (0.15, 0.0, 0.0)),
    (0.30, 180.0, 0.05, 0.0, "P", 2.0, (0.0, 0.0, 0.1)),
    (0.0, 0.0, 0.0, 0.0, "R", 1.0, (0.0, 0.01, 0.05)),
)
LIMITS_M = [-0.4, 1.1]


def entries(rows: tuple[Row, ...]) -> list[dict[str, Any]]:
    """Return the joints of a robot file."""
    result = []
    for k, (a, alpha, d, theta, kind, mass, com) in enumerate(rows):
        joint: dict[str, Any] = {"name": f"{'X' if kind == 'P' else 'A'}{k + 1}", "a_m": a, "alpha_deg": alpha}
        joint |= {"d_m": d, "theta_deg": theta, "link": {"name": f"part{k + 1}", "mass_kg": mass, "com_m": list(com)}}
        result.append(joint | ({"type": "prismatic", "limits_m": LIMITS_M} if kind == "P" else {}))
    return result


def robot_of(rows: tuple[Row, ...], convention: str = "modified-dh") -> RobotFile:
    """Return rows as a robot file; in "dh" the same numbers describe another robot."""
    document = {"schema": "stiffcal/robot/1", "convention": convention, "joints": entries(rows)}
    return RobotFile.model_validate(document)


def draw_joints(chain: Chain, n: int, seed: int) -> Floats:
    """Draw (n, J) logged angles of up to ±2 rad, and positions within limits, m."""
    rng = np.random.default_rng(seed)
    low, high = (np.where(chain.prismatic, chain.limits[:, k], 4.0 * k - 2.0) for k in (0, 1))
    return rng.uniform(low, high, (n, chain.n_joints))
