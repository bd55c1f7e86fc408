"""Numbers in tables that may be in another unit than they are read in: radians, metres, kN; a table's faults."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault
from stiffcal.wording import length, significant

# As for tables that are measured (`stiffcal.mistakes.displacements.unit_slips`): no joint turns by more than ±2π
# radians, and poses in degrees have two joints within ±2π of zero, and none beyond, only next to the zero pose. Many
# robots stand at (0, -π/2, π/2, 0, 0, 0) at home.
MOST_RADIANS, LEAST_JOINTS = 2.0 * np.pi, 2
# No pose of a robot's tool lies within a centimetre of its base's origin.
MOST_METRES = 0.01
# A robot's give is below 5 cm; no instrument at its tool resolves a hundredth of a millimetre (trackers: 15 µm).
LARGEST_M, SMALLEST_M = 0.05, 1e-5
# Faults that are printed of one table.
MOST_PRINTED = 10


def angle_doubts(
    angles: Floats, where: str, mend: str, what: str = "joint angles", least: int = LEAST_JOINTS
) -> list[str]:
    """Return a warning where angles that were read as degrees look like radians.

    Parameters
    ----------
    angles : (n, L) of the joints that turn, or (n, 3) of orientations, rad, whose unit is not stated.
    where : the file or option that they are from. mend : what to do.
    what : what they are. least : how many of the L have to be elsewhere than at zero.

    Examples
    --------
    >>> len(angle_doubts(np.radians([[0.1, -1.2, 1.6]]), "poses.csv", "write the unit"))
    1
    >>> len(angle_doubts(np.radians([[0.0, -1.57, 1.57, 0.0]]), "poses.csv", "write the unit"))
    1
    >>> angle_doubts(np.radians([[0.0, -70.0, 20.0]]), "poses.csv", "write the unit")
    []
    """
    degrees = np.degrees(np.abs(angles))
    least = min(least, angles.shape[1])
    if not degrees.size or degrees.max() > MOST_RADIANS or np.any(degrees > 0.0, axis=0).sum() < least:
        return []
    return [f"{where}: all {what} lie within {significant(degrees.max())} degrees of zero: are they in radians? {mend}"]


def position_doubts(position: Floats, where: str, mend: str) -> list[str]:
    """Return a warning where positions (n, 3), m, that were read as millimetres look like metres."""
    if np.abs(position).max(initial=0.0) >= MOST_METRES:
        return []
    return [f"{where}: all positions lie within {length(MOST_METRES)} of the base: are they in metres? {mend}"]


def deflection_doubts(deflection: Floats, wrench: Floats, where: str, mend: str) -> list[str]:
    """Return a warning where the deflections under loads are none that a robot has: the loads are in another unit.

    Parameters
    ----------
    deflection : (n, 6) m and rad. wrench : (n, 6) N and N·m.
    where : the file or option that the loads are from.
    mend : what to do where they are too small; "": their unit is stated, and small ones are meant.
    """
    if not np.any(wrench):
        return []
    largest = float(np.linalg.norm(deflection[:, :3], axis=1).max())
    force = float(np.linalg.norm(wrench[:, :3], axis=1).max())
    loads = f"loads of up to {significant(force)} N" if force > 0.0 else "these loads"
    if largest > LARGEST_M:
        text = f"{loads} deflect the robot by {length(largest)}, more than robots give: check their unit"
        return [f"{where}: {text}"]
    if largest < SMALLEST_M and mend:
        text = f"{loads} deflect the robot by {length(largest, digits=2)}, less than instruments at it show"
        return [f"{where}: {text}: are they in kN? {mend}"]
    return []


def shortened(faults: list[Fault]) -> list[Fault]:
    """Return the first faults of many, the last of them with how many more there are."""
    if len(faults) <= MOST_PRINTED:
        return faults
    last = faults[MOST_PRINTED - 1]
    more = f"{last.reason} (and {len(faults) - MOST_PRINTED} more lines)"
    return [*faults[: MOST_PRINTED - 1], Fault(last.code, last.file, last.place, more, last.mend)]
