"""Rows in which a log has readings of a signal: of a lost target, and where one table holds signals of several clocks.

Tables of PlotJuggler, asammdf and their like put the samples of several topics below each other, by the union of their
times: cells of the other topics are empty. Each topic is then a source of its own, with its own rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stiffcal.campaign.signals.row_filter import condition_text
from stiffcal.escapes import toml_text
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.lines import ProposedLine

# Signals of one device have their readings in the same rows.
_DEVICES = (
    ("joints",),
    ("force", "moment", "mass"),
    ("deflection", "rotation"),
    ("position", "quaternion", "matrix"),
)


def by_rows(roles: Roles) -> tuple[Roles, ...]:
    """Return the signals apart that have their readings in rows of their own; one entry where they share them.

    Parameters
    ----------
    roles : what the columns of a log are.
    """
    groups: list[tuple[set[str], set[int]]] = []
    for names in _DEVICES:
        held = [role for name in names if (role := _role(roles, name)) is not None]
        if not held:
            continue
        rows = _rows(held[0])
        own = next((group for group in groups if group[1] == rows), None)
        if own is None:
            groups.append((set(names), rows))
        else:
            own[0].update(names)
    if len(groups) < 2:
        return (roles,)
    every = {name for names in _DEVICES for name in names}
    return tuple(_without(roles, every - names) for names, _ in groups)


def _without(roles: Roles, names: set[str]) -> Roles:
    nothing: dict[str, None] = dict.fromkeys(names)
    return replace(roles, targets=(), **nothing)  # type: ignore[arg-type]


def rows_line(roles: Roles, of_several: bool = False) -> ProposedLine | None:
    """Return the line that keeps the rows in which there is a reading; None where every row has one.

    Parameters
    ----------
    roles : of one device.
    of_several : whether the table holds rows of other devices: then further down may stand rows without a reading.
    """
    held = [role for names in _DEVICES for name in names if (role := _role(roles, name)) is not None]
    conditions: list[str] = []
    without = 0
    for role in held:
        column = role.columns[0]
        if len(column.values) < len(column.has_reading) and not conditions:
            conditions.append(condition_text(column.header, "!=", ""))
            without = len(column.has_reading) - len(column.values)
    if of_several and held and not conditions:
        conditions.append(condition_text(held[0].columns[0].header, "!=", ""))
    lost = _zeros(roles.position) if roles.position is not None else 0
    if lost and roles.position is not None:
        conditions.append(condition_text(roles.position.columns[0].header, "!=", 0))
    if not conditions:
        return None
    left_out = without + lost
    doubt = f"{left_out} of the rows looked at have no reading and are left out" if left_out else None
    return ProposedLine(toml_text.pair("rows", " and ".join(conditions)), doubt)


def _role(roles: Roles, name: str) -> Role | None:
    found = getattr(roles, name)
    return found if isinstance(found, Role) else None


def _rows(role: Role) -> set[int]:
    return {k for k, found in enumerate(role.columns[0].has_reading) if found}


def _zeros(role: Role) -> int:
    """Return the number of rows in which a place is 0 in all three columns: how some programs write a lost target."""
    columns: Sequence[tuple[float, ...]] = [column.values for column in role.columns]
    return sum(1 for row in zip(*columns, strict=False) if not any(row))
