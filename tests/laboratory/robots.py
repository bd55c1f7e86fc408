"""Robots that the independent tests and the benchmarks share, given as numbers, with no reader in between."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain

SIX_AXES = (
    # a m, alpha deg, d m, theta deg, mass kg, centre of mass m: modified DH, a medium-size handling robot
    (0.0, 0.0, 0.68, 0.0, 120.0, (0.10, 0.0, -0.10)),
    (0.2, -90.0, 0.0, 0.0, 90.0, (0.40, 0.0, 0.06)),
    (0.89, 0.0, 0.0, -90.0, 100.0, (0.08, 0.15, 0.0)),
    (0.15, -90.0, 0.88, 0.0, 30.0, (0.0, 0.0, -0.25)),
    (0.0, 90.0, 0.0, 0.0, 12.0, (0.0, 0.02, 0.0)),
    (0.0, -90.0, 0.0, 0.0, 6.0, (0.0, 0.0, 0.10)),
)
SIX_STIFFNESS = np.array([731.82, 488.31, 428.61, 59.52, 56.87, 16.55]) * 1e3
"""N·m/rad: the values identified in Wang, Zhang, Fuhlbrigge 2009, section III.C."""
SIX_CENTRE_DEG = np.array([0.0, -75.0, 15.0, 0.0, 0.0, 0.0])
SIX_SPREAD_DEG = np.array([60.0, 35.0, 35.0, 100.0, 90.0, 120.0])

SEVEN_AXES = (
    (0.0, 0.0, 0.30, 0.0, 6.0, (0.0, 0.0, -0.10)),
    (0.0, -90.0, 0.0, 0.0, 5.0, (0.0, -0.10, 0.0)),
    (0.0, 90.0, 0.42, 0.0, 4.0, (0.0, 0.0, -0.12)),
    (0.0, 90.0, 0.0, 0.0, 4.0, (0.0, 0.10, 0.0)),
    (0.0, -90.0, 0.40, 0.0, 3.0, (0.0, 0.0, -0.10)),
    (0.0, -90.0, 0.0, 0.0, 2.0, (0.0, 0.0, 0.0)),
    (0.0, 90.0, 0.0, 0.0, 1.0, (0.0, 0.0, 0.06)),
)
SEVEN_STIFFNESS = np.array([60.0, 70.0, 45.0, 50.0, 30.0, 20.0, 12.0]) * 1e3


def modified_dh(a: float, alpha: float, d: float) -> Floats:
    """Return the fixed transform of one row of modified (Craig) Denavit-Hartenberg parameters, theta left out."""
    c, s = np.cos(alpha), np.sin(alpha)
    return np.array([[1, 0, 0, a], [0, c, -s, -s * d], [0, s, c, c * d], [0, 0, 0, 1]], dtype=np.float64)


def shifted(x: float, y: float, z: float) -> Floats:
    """Return a translation as a (4, 4) transform."""
    transform = np.eye(4)
    transform[:3, 3] = x, y, z
    return transform


def turned(transform: Floats, axis: int, angle: float) -> Floats:
    """Return ``transform`` followed by a turn about its own axis 0, 1 or 2."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(4)
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return np.asarray(transform @ turn, dtype=np.float64)


def chain_from_rows(
    name: str,
    rows: tuple[tuple[float, float, float, float, float, tuple[float, float, float]], ...],
    flange: Floats,
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
) -> Chain:
    """Build a `Chain` from rows of modified Denavit-Hartenberg parameters with masses."""
    n = len(rows)
    return Chain(
        name=name,
        joint_names=tuple(f"A{k + 1}" for k in range(n)),
        fixed=np.stack([modified_dh(row[0], np.radians(row[1]), row[2]) for row in rows]),
        flange=flange,
        coupling=np.eye(n),
        offset=np.radians([row[3] for row in rows]),
        limits=np.tile([-np.inf, np.inf], (n, 1)),
        gear_ratio=np.ones(n),
        gear_orders=((),) * n,
        mechanical=np.zeros(n, dtype=np.bool_),
        bearing=np.zeros(n),
        link_names=tuple(f"link{k + 1}" for k in range(n)),
        link_mass=np.array([row[4] for row in rows]),
        link_com=np.array([row[5] for row in rows]),
        masses_known=True,
        gravity=np.array(gravity),
    )


DEGREES = np.full(6, np.pi / 180.0)
"""The unit of six logged angles, rad."""


def six_axes() -> Chain:
    """Return the medium six-axis robot."""
    return chain_from_rows("medium six-axis", SIX_AXES, shifted(0.0, 0.0, 0.14))


def seven_axes() -> Chain:
    """Return the seven-axis arm, hung from a wall to make gravity point sideways."""
    return chain_from_rows("seven-axis arm", SEVEN_AXES, shifted(0.0, 0.0, 0.15), (0.0, -9.81, 0.0))


def six_axis_joints(rng: np.random.Generator, n: int) -> Floats:
    """Draw (n, 6) logged joint angles, rad, inside the medium robot's working range."""
    return np.radians(SIX_CENTRE_DEG + SIX_SPREAD_DEG * rng.uniform(-1.0, 1.0, (n, 6)))


def force_sensor_setup(
    chain: Chain, tool_mass: float = 0.0, tool_com: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> MeasurementSetup:
    """Return a set-up of a turned force sensor and a target off the flange's axis."""
    flange = chain.n_joints + 1
    sensor = Attachment(flange, turned(shifted(0.0, 0.0, 0.06), 2, 0.6))
    return MeasurementSetup(
        wrench_axes=sensor,
        wrench_point=sensor,
        targets=(Attachment(flange, turned(shifted(0.06, -0.04, 0.10), 0, -0.3)),),
        target_names=("target",),
        moments_measured=True,
        tool_mass=tool_mass,
        tool_com=np.array(tool_com),
    )
