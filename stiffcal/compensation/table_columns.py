"""Which column of a table for a command is which, by the names that people give them, and its factor to SI."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from stiffcal.campaign.columns.column_headers import ColumnHeader, header_parts
from stiffcal.campaign.columns.column_names import Reading, component_of, components_of_arrays
from stiffcal.campaign.columns.column_words import QUATERNIONS, TIMES, plain_name
from stiffcal.campaign.columns.joint_names import numbered_joints
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.quantities import unit

FORCES, MOMENTS, POSITION = ("Fx", "Fy", "Fz"), ("Tx", "Ty", "Tz"), ("X", "Y", "Z")
AXES = (*FORCES, *MOMENTS)
QUATERNION, ANGLES = ("qw", "qx", "qy", "qz"), ("roll", "pitch", "yaw")
TIME, SEGMENT = "t", "segment"
QUANTITIES: Mapping[str, tuple[str, str]] = (
    dict.fromkeys(FORCES, ("force", "N"))
    | dict.fromkeys(MOMENTS, ("moment", "N*m"))
    | dict.fromkeys(POSITION, ("position", "mm"))
    | dict.fromkeys(ANGLES, ("angle", "deg"))
    | {TIME: ("time", "s")}
)
"""Quantity of a column, and its unit where none is stated; those of joints are angles in degrees, or lengths in mm."""
_OF_READING: Mapping[Reading, tuple[str, ...]] = {
    Reading.FORCE: FORCES,
    Reading.MOMENT: MOMENTS,
    Reading.POSITION: POSITION,
}


@dataclass(frozen=True)
class ReadColumn:
    """A column of a table."""

    header: str
    """As written."""
    name: str | None
    """As the names of this module have it, or a joint's; None: it is not read."""
    factor: float = 1.0
    """To SI."""
    stated: bool = False
    """Whether its unit stands in the table."""


def columns_of(
    headers: Sequence[str],
    units: Sequence[str],
    joint_names: Sequence[str],
    asked: Sequence[str],
    display_name: str,
    place: str,
    prismatic: Collection[str] = (),
) -> list[ReadColumn]:
    """Return what each column of a table is.

    Parameters
    ----------
    headers : as written. units : of a row below them, "" where there is none; empty without such a row.
    joint_names : of the robot. asked : the names that are read: joints, and those of this module.
    display_name, place : of the table and of its header, for faults. prismatic : joints that are in mm, not degrees.

    Raises
    ------
    InputError : a unit is not known, a column may mean several things, or two columns mean the same.

    Examples
    --------
    >>> table = ["a1", "Mx", "F_z [kN]", "note"]
    >>> [column.name for column in columns_of(table, (), ["A1"], ("A1", *AXES), "a.csv", "line 1")]
    ['A1', 'Tx', 'Fz', None]
    >>> table = [f"wrench[{k}]" for k in range(6)]
    >>> [column.name for column in columns_of(table, (), (), AXES, "a.csv", "line 1")]
    ['Fx', 'Fy', 'Fz', 'Tx', 'Ty', 'Tz']
    """
    parts = [header_parts(header.strip()) for header in headers]
    below = [written or None for written in units] or [None] * len(headers)
    parts = [ColumnHeader(part.name, part.unit or written) for part, written in zip(parts, below, strict=True)]
    joints = _joints_by_header([part.name for part in parts], joint_names)
    of_arrays = components_of_arrays(part.name for part in parts)
    parts = [ColumnHeader(of_arrays.get(part.name, part.name), part.unit) for part in parts]
    names = {k: joints.get(k) or _name_of(part, asked) for k, part in enumerate(parts)}
    _check_open(parts, headers, set(joints), set(names.values()), display_name, place)
    columns: list[ReadColumn] = []
    first: dict[str, str] = {}
    for k, header in enumerate(headers):
        written, name = parts[k].unit, names[k]
        if name is None or name not in asked:
            columns.append(ReadColumn(header, None))
            continue
        if name in first:
            reason = f"columns {first[name]} and {header.strip()} are both read as {name}"
            raise InputError.at(FaultCode.COLUMN_DUPLICATE, display_name, place, reason, "leave one of them out")
        first[name] = header.strip()
        factor = _factor(name, written, joint_names, prismatic, display_name, f"{place}, column {header.strip()}")
        columns.append(ReadColumn(header, name, factor, written is not None))
    return columns


def joints_in_words(joint_names: Sequence[str], prismatic: Collection[str]) -> str:
    """Return the joints and the unit of their columns, as in a mend."""
    lengths = [name for name in joint_names if name in prismatic]
    unit_words = f"degrees; {', '.join(lengths)}: mm" if lengths else "degrees"
    return f"{', '.join(joint_names)} ({unit_words})"


def _joints_by_header(names: Sequence[str], joint_names: Sequence[str]) -> dict[int, str]:
    """Return the joint of each column that is one: by the robot's names, or numbered from base to tip."""
    found = {k: name for k, name in enumerate(names) if name in joint_names}
    if found or not joint_names:
        return found
    joint_of = {plain_name(joint): joint for joint in joint_names if plain_name(joint)}
    plain = [plain_name(name) for name in names]
    found = {k: joint_of[word] for k, word in enumerate(plain) if word in joint_of}
    if found and len(joint_of) == len(joint_names):
        return found
    numbered = numbered_joints(names)
    if len(numbered) != len(joint_names):
        return {}
    return {names.index(name): joint for name, joint in zip(numbered, joint_names, strict=True)}


def _name_of(part: ColumnHeader, asked: Sequence[str]) -> str | None:
    """Return what a column that is no joint's is; None where this is not known."""
    if part.name in asked and part.name not in AXES:
        return part.name
    plain = plain_name(part.name)
    for known in (*ANGLES, SEGMENT):
        if plain == known:
            return known
    if plain in TIMES and len(plain) > 1:  # T is a temperature as well
        return TIME
    for names in QUATERNIONS:
        if plain in names:
            return QUATERNION[names.index(plain)]
    component = component_of(part.name, part.unit)
    if component is None or component.is_open or component.doubt or component.body:
        return None
    if component.reading not in _OF_READING:
        return None
    return _OF_READING[component.reading][component.axis]


def _check_open(
    parts: Sequence[ColumnHeader],
    headers: Sequence[str],
    joints: Collection[int],
    names: Collection[str | None],
    display_name: str,
    place: str,
) -> None:
    """Raise where a column may be a moment, and no other column is one: it would count as zero."""
    if any(name in MOMENTS for name in names):
        return
    for k, part in enumerate(parts):
        component = None if k in joints else component_of(part.name, part.unit)
        if component is not None and component.is_open:
            reason = f"column {headers[k].strip()} may be a moment or a rotation: no unit stands by it"
            mend = (
                f'write {MOMENTS[component.axis]} for a moment, or "{part.name} [rad]" for a rotation, or leave it out'
            )
            raise InputError.at(FaultCode.COLUMN_AMBIGUOUS, display_name, place, reason, mend)


def _factor(
    name: str,
    written: str | None,
    joint_names: Sequence[str],
    prismatic: Collection[str],
    display_name: str,
    place: str,
) -> float:
    quantity, default = QUANTITIES.get(name, ("", ""))
    if name in joint_names:
        quantity, default = ("length", "mm") if name in prismatic else ("angle", "deg")
    if not quantity:
        return 1.0
    try:
        return unit(written or default, quantity).factor
    except ValueError as error:
        raise InputError.at(
            FaultCode.UNIT_UNKNOWN, display_name, place, str(error), f"write it in {default}"
        ) from error
