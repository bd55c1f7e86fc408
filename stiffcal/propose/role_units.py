"""How the columns of a signal are written: their names and their unit."""

from __future__ import annotations

from stiffcal.campaign.toml.typed import expand_columns
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.column_roles import Role
from stiffcal.quantities import UnknownUnitError, unit

LARGEST_RADIAN = 6.6
"""A joint angle beyond one turn and a bit is not in radians."""
LONGEST_M = 50.0
"""No linear axis of a robot is longer: larger numbers are mm."""
# A robot's give is below 5 cm; no reach is above 20 m.
_LARGEST_DEFLECTION_M = 0.05
_LARGEST_POSITION_M = 20.0


def unit_of_signal(role: Role, signal: str, *, prismatic: bool = False) -> tuple[str, bool]:
    """Return the unit of a signal's columns, and whether it was guessed by the size of their values.

    Parameters
    ----------
    role : the columns. signal : the field of `Roles` that holds them; prismatic : of joints that are linear axes.

    Raises
    ------
    InputError
        As `unit_of_role`.
    """
    size = max(column.size for column in role.columns)
    match signal:
        case "joints" if prismatic:
            return unit_of_role(role, "length", "m" if size < LONGEST_M else "mm")
        case "joints":
            return unit_of_role(role, "angle", "deg" if size > LARGEST_RADIAN else "rad")
        case "rotation":
            return unit_of_role(role, "angle", "rad" if size < _LARGEST_DEFLECTION_M else "deg")
        case "deflection":
            likely = "m" if size < _LARGEST_DEFLECTION_M else "mm" if size < _LARGEST_DEFLECTION_M * 1e3 else "um"
            return unit_of_role(role, "translation", likely)
        case "position":
            return unit_of_role(role, "position", "m" if size < _LARGEST_POSITION_M else "mm")
        case _:
            return unit_of_role(role, signal, {"force": "N", "moment": "N*m", "mass": "kg"}[signal])


def unit_of_role(role: Role, quantity: str, likely: str) -> tuple[str, bool]:
    """Return the unit of a signal's columns and whether it was guessed.

    Parameters
    ----------
    role : the columns. quantity : as in `stiffcal.quantities`. likely : the unit where none is written.

    Raises
    ------
    InputError
        The header names a unit that is not known for the quantity, or the columns differ.
    """
    written = {column.unit for column in role.columns}
    if written == {None}:
        return likely, True
    names = set()
    for column in role.columns:
        place = f'column "{column.header}"'
        if column.unit is None:
            raise InputError.at(
                FaultCode.UNIT_CONFLICT,
                "",
                place,
                "it has no unit, but neighbouring columns do",
                "write the unit into the header",
            )
        try:
            names.add(unit(column.unit, quantity).name)
        except UnknownUnitError as error:
            raise InputError.at(FaultCode.UNIT_UNKNOWN, "", place, error.reason, error.mend) from None
    if len(names) > 1:
        units = ", ".join(sorted(names))
        raise InputError.at(
            FaultCode.UNIT_CONFLICT, "", f'column "{role.columns[0].header}"', f"units differ: {units}", "use one unit"
        )
    return names.pop(), False


def columns_text(role: Role) -> str:
    """Write column names: as a range where that means the same, else as a list."""
    headers = [column.header for column in role.columns]
    if len(headers) > 3:
        text = f"{headers[0]}..{headers[-1]}"
        try:
            if expand_columns(text) == tuple(headers):
                return toml_text.value(text)
        except ValueError:
            pass
    return "[" + ", ".join(toml_text.value(header) for header in headers) + "]"
