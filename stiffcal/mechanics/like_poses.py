"""Which of many configurations are the same pose.

Comparing every configuration with every pose found so far takes time with their product. A grid over the three joints
that vary most leaves, for a configuration, the few poses of its own cell and of those next to it.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers

SAME_POSE_RAD = float(np.radians(1.0))
"""Configurations whose joints differ by less are one pose: drives repeat what a program commands within arc seconds,
and tables are rounded to less than this."""
# Joints that span the grid: with three, a cell has 27 neighbours, itself included.
GRID_JOINTS = 3
# Cells are this much wider than the tolerance, so that rounding never puts two like angles two cells apart.
WIDER = 1.0 + 1e-9


def joint_phases(angles: Floats, prismatic: Booleans) -> Floats:
    """Return angles whose sines and cosines say how far joints are apart: of a length half a turn over its range.

    Parameters
    ----------
    angles : (J, n) joint angles, rad; of prismatic joints m.
    prismatic : (J,) True where it is a length.

    Examples
    --------
    >>> joint_phases(np.array([[0.3, 0.4], [1.0, 3.0]]), np.array([False, True])).round(4).tolist()
    [[0.3, 0.4], [0.0, 3.1416]]
    """
    if not prismatic.any() or not angles.shape[1]:
        return angles
    low, extent = angles.min(axis=1, keepdims=True), np.ptp(angles, axis=1)[:, None]
    share = (angles - low) / np.where(extent > 0.0, extent, 1.0)
    return np.where(prismatic[:, None], np.pi * share, angles)


def pose_groups(angles: Floats, tolerance: float) -> Integers:
    """Return (n,) the number of each configuration's pose, in the order in which poses first appear.

    A configuration belongs to the first pose whose founder (the first configuration of it) differs from it by less than
    the tolerance in every joint; where there is none, it founds the next one.

    Parameters
    ----------
    angles : (n, J) joint angles, rad, finite; of prismatic joints m, 1 m as 1 rad (`stiffcal.mechanics.chain`).
    tolerance : rad, above zero.

    Examples
    --------
    >>> pose_groups(np.radians([[0.0, 10.0], [0.0, 40.0], [0.4, 10.0]]), np.radians(1.0)).tolist()
    [0, 1, 0]
    """
    widest = np.argsort(-np.ptp(angles, axis=0), kind="stable")[:GRID_JOINTS] if len(angles) else np.arange(0)
    cells = np.floor(angles[:, widest] / (WIDER * tolerance)).astype(np.int64)
    around = list(product((-1, 0, 1), repeat=len(widest)))
    rows = angles.tolist()
    group = np.empty(len(angles), dtype=np.int64)
    founders: list[list[float]] = []
    by_cell: dict[tuple[int, ...], list[int]] = {}
    for place, (cell, pose) in enumerate(zip(cells.tolist(), rows, strict=True)):
        near = [
            number
            for step in around
            for number in by_cell.get(tuple(map(int.__add__, cell, step)), ())
            if all(
                abs(pose_angle - founder_angle) < tolerance
                for pose_angle, founder_angle in zip(pose, founders[number], strict=True)
            )
        ]
        group[place] = min(near, default=len(founders))
        if not near:
            by_cell.setdefault(tuple(cell), []).append(len(founders))
            founders.append(pose)
    return group
