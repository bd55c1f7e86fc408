"""Which column of a table holds which joint of a URDF, by the joints' names."""

from __future__ import annotations

import re
from collections.abc import Sequence

from stiffcal.propose.table_sniffing import SniffedColumn

_ANGLE_WORDS = ("pos", "angle", "actual", "q", "winkel")
_OTHER_WORDS = ("vel", "eff", "torque", "current", "acc", "cmd", "command", "target", "goal", "std", "temp")


def columns_of_joints(columns: Sequence[SniffedColumn], joint_names: Sequence[str]) -> dict[str, SniffedColumn]:
    """Return the column of each joint that has one, by the joint's name.

    A column is that of a joint where both names are the same but for case, separators and the word "joint", or where
    the column's name holds the joint's (``position.elbow_joint``) and no other column's does as well.

    Parameters
    ----------
    columns : of a table; columns of words are left aside.
    joint_names : of the robot, in any order.

    Examples
    --------
    >>> table = [SniffedColumn(name, name, None, (0.0,)) for name in ("t", "Shoulder_Pan", "position.elbow_joint")]
    >>> found = columns_of_joints(table, ["shoulder_pan_joint", "elbow_joint"])
    >>> {name: column.header for name, column in found.items()}
    {'shoulder_pan_joint': 'Shoulder_Pan', 'elbow_joint': 'position.elbow_joint'}
    """
    numbers = [column for column in columns if column.values]
    found: dict[str, SniffedColumn] = {}
    for name in joint_names:
        column = _column_of(name, [column for column in numbers if column not in found.values()])
        if column is not None:
            found[name] = column
    return found


def _column_of(joint: str, columns: Sequence[SniffedColumn]) -> SniffedColumn | None:
    key, bare = _plain(joint), _bare(joint)
    for same in (
        [column for column in columns if _plain(column.name) == key],
        [column for column in columns if _bare(column.name) == bare],
    ):
        if len(same) == 1:
            return same[0]
    if len(key) < 3:  # "a1" lies in too many names
        return None
    holding = [column for column in columns if key in _plain(column.name)]
    if len(holding) > 1:
        rest = {column.header: _plain(column.name).replace(key, "") for column in holding}
        holding = [column for column in holding if not any(word in rest[column.header] for word in _OTHER_WORDS)]
        angles = [column for column in holding if any(word in rest[column.header] for word in _ANGLE_WORDS)]
        holding = angles or holding
    return holding[0] if len(holding) == 1 else None


def _plain(name: str) -> str:
    return "".join(re.findall(r"[a-z0-9]+", name.lower()))


def _bare(name: str) -> str:
    """Return the name without the word "joint", unless nothing but a number is left."""
    plain = _plain(name)
    bare = plain.replace("joint", "")
    return bare if bare and not bare.isdigit() else plain
