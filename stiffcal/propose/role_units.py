"""How the columns of a signal are written: their names and their unit."""

from __future__ import annotations

from stiffcal.campaign.toml.typed import expand_columns
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.column_roles import Role
from stiffcal.quantities import UnknownUnitError, unit


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
