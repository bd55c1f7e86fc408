"""Which kind of experiment a table can serve, where it lacks loads, displacements, or unloaded states."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.campaign.found.experiment_kinds import kind_names
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.like_poses import SAME_POSE_RAD, pose_groups
from stiffcal.propose.column_roles import Role, Roles

_MOST_RADIANS = 6.6  # larger angles are degrees


def serves_absolute(roles: Roles) -> bool:
    """Return whether a table is joint angles and places of a target, without a force and without unloaded twins.

    Parameters
    ----------
    roles : what its columns are.
    """
    if roles.joints is None or roles.position is None or roles.deflection is not None or roles.force is not None:
        return False
    return roles.mass is None or not _has_twins(roles, roles.mass)


def check_purpose(roles: Roles, display_name: str) -> None:
    """Refuse a table from which no stiffness can be identified, with what it could serve instead.

    Parameters
    ----------
    roles : what its columns are. display_name : the table's name, for the fault.

    Raises
    ------
    InputError
        Joint angles, loads or displacements are missing, or each pose was measured once only.
    """
    if roles.joints is None:
        mend = "name them A1 … A6, J1 …, q1 … or theta1 …, or as in the robot file or URDF (--robot, --urdf FILE)"
        raise _missing(display_name, "no joint columns recognised", mend)
    if serves_absolute(roles):
        return
    loads, moved = (
        roles.force is not None or roles.mass is not None,
        roles.deflection is not None or roles.position is not None,
    )
    if not loads and not moved:
        reason = "no force columns and no displacement columns recognised"
        raise _missing(
            display_name, reason,
            "name them Fx, Fy, Fz (or kg) and dx, dy, dz; joint angles with torques or currents of the drives over "
        "time make a friction run: stiffcal init DIR --kind friction --from LOG",
        )  # fmt: skip
    if not loads:
        raise _missing(
            display_name, "no force columns recognised",
            "name them Fx, Fy, Fz, or kg for dead weights; displacements without their loads cannot be used",
        )  # fmt: skip
    if not moved:
        raise _missing(
            display_name, "no displacement or position columns recognised",
            "name them dx, dy, dz (loaded minus unloaded) or X, Y, Z; joint angles with loads on a clamped tool make "
        "a clamped run: stiffcal init DIR --kind clamped --from LOG",
        )  # fmt: skip
    if roles.deflection is None and not _rows_of_one_pose(roles):
        what = 'experiment = "absolute"' if "absolute" in kind_names() else _ABSOLUTE
        raise InputError.at(
            FaultCode.DATA_MISSING, display_name, "",
            "every row is a different pose: stiffness requires each pose unloaded and loaded, as two rows or more",
            "measure each pose unloaded too, or write displacements as dx, dy, dz; as it is, the table can be used "
        f"for {what}",
        )  # fmt: skip


_ABSOLUTE = "a calibration of the kinematics alone, which stiffcal does not do"


def _missing(display_name: str, reason: str, mend: str) -> InputError:
    return InputError.at(FaultCode.COLUMN_MISSING, display_name, "header", reason, mend)


def _has_twins(roles: Roles, mass: Role) -> bool:
    """Return whether most rows have a twin: the same pose under another mass. A pose that repeats is none."""
    pose = _poses(roles)
    masses = np.array(mass.columns[0].values)
    if pose is None or masses.size != pose.size:  # with empty cells it cannot be decided
        return True
    largest, smallest = np.full(pose.max() + 1, -np.inf), np.full(pose.max() + 1, np.inf)
    np.maximum.at(largest, pose, masses)
    np.minimum.at(smallest, pose, masses)
    return bool(np.mean((largest > smallest)[pose]) > 0.5)


def _rows_of_one_pose(roles: Roles) -> list[int]:
    """Return the first rows, from 1, that share their joint angles; empty where each row is another pose."""
    pose = _poses(roles)
    if pose is None:  # with empty cells it cannot be decided
        return [1, 2]
    shared = np.flatnonzero(np.bincount(pose) > 1)
    return [int(row) + 1 for row in np.flatnonzero(pose == shared[0])] if shared.size else []


def _poses(roles: Roles) -> Integers | None:
    """Return (n,) the number of each row's pose, from 0; None where columns of joints differ in length."""
    assert roles.joints is not None
    columns = [column.values for column in roles.joints.columns]
    if len({len(values) for values in columns}) > 1:
        return None
    degrees = max(column.size for column in roles.joints.columns) > _MOST_RADIANS
    angles = np.array(columns).T
    return pose_groups(np.radians(angles) if degrees else angles, SAME_POSE_RAD)
