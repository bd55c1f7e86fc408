"""What the columns of a table without a header are, by what their values can be: decided by physics or left open.

A clock ticks evenly, a sensor's log begins at zero load, a target stays far from the origin; which columns of a table
of states are a robot's joints is shown by its kinematics (`unnamed_states`). What more than one reading explains stays
open: a person then writes a line of names.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.mechanics.chain import Chain
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.propose.unnamed_states import (
    LARGEST_DEFLECTION_MM,
    LARGEST_RADIAN,
    UNLOADED,
    numbers_of,
    of_states,
    within_limits,
)
from stiffcal.table_layout.layout import NAMELESS

_NUMBERED = re.compile(rf"{NAMELESS}\d{{1,6}}")
# Of the distance from the origin: how far a target or a joint goes under a load.
_STANDS = 0.1
_FIRST_ROWS = 5
_LEAST_ROWS = 3
# A log of holds has a row a second at least: larger steps count milliseconds.
_LONGEST_STEP_S = 1.0
# Without the robot: so many angles in degrees. The last axis turns by less than this; places in mm go further.
_USUAL_JOINTS, _LARGEST_ANGLE_DEG = (6, 7), 400.0


def are_numbered(headers: Sequence[str]) -> bool:
    """Return whether names of columns are those of a table without a header.

    Examples
    --------
    >>> are_numbered(["column1", "column2"]), are_numbered(["t", "column2"])
    (True, False)
    """
    return bool(headers) and all(_NUMBERED.fullmatch(header) for header in headers)


def missing_names(columns: Sequence[SniffedColumn], roles: Roles) -> str:
    """Return what a person is to write above a table: the names that are known, and a ? for each column that is open.

    Parameters
    ----------
    columns : of the table. roles : as `roles_by_values` returns them.

    Examples
    --------
    >>> own = [SniffedColumn(f"column{k}", f"column{k}", None, (0.0,)) for k in (1, 2)]
    >>> missing_names(own, Roles(time=own[0]))
    't,?'
    """
    names = {roles.time.header: "t"} if roles.time is not None else {}
    for role, stem in ((roles.force, "F"), (roles.moment, "M"), (roles.deflection, "d"), (roles.position, "")):
        if role is not None:
            axes = "XYZ" if role is roles.position else "xyz"
            names |= {column.header: f"{stem}{axis}" for column, axis in zip(role.columns, axes, strict=True)}
    if roles.joints is not None:
        names |= {column.header: f"A{k}" for k, column in enumerate(roles.joints.columns, start=1)}
    return ",".join(names.get(column.header, "?") for column in columns)


def roles_by_values(
    columns: Sequence[SniffedColumn], chain: Chain | None, tool: Sequence[float] | None = None
) -> Roles:
    """Return what columns without names are, as far as their values decide it; the others are `Roles.unused`.

    Parameters
    ----------
    columns : of the table. chain : of the robot that was measured; None: not known. tool : the load's point, m, flange.
    """
    numbers = [column for column in columns if column.values and all(np.isfinite(column.values))]
    full = max((len(column.values) for column in numbers), default=0)
    numbers = [column for column in numbers if len(column.values) == full]
    time = next((column for column in numbers if _ticks(column)), None)
    rest = [column for column in numbers if column is not time and not _is_row_number(column)]
    roles = Roles()
    if chain is not None and full >= _LEAST_ROWS:
        roles = of_states(rest, chain, np.zeros(3) if tool is None else np.array(tool))
    if roles == Roles() and time is not None and full > _FIRST_ROWS:
        roles = _of_log(rest, chain)
        if roles != Roles():
            time = _with_unit(time)
    if roles == Roles():
        return Roles(time=time, unused=tuple(column for column in columns if column != time))
    roles = replace(roles, time=time)
    taken = {column for role in vars(roles).values() if isinstance(role, Role) for column in role.columns}
    headers = {column.header for column in taken} | ({time.header} if time is not None else set())
    return replace(roles, unused=tuple(column for column in columns if column.header not in headers))


def _with_unit(time: SniffedColumn) -> SniffedColumn:
    step = float(np.median(np.diff(time.values)))
    if time.unit is not None or step <= _LONGEST_STEP_S:
        return time
    return replace(time, unit="ms", doubt=f"ms, as a row each {step:.4g} s would be too few")


def _ticks(column: SniffedColumn) -> bool:
    """Return whether a column grows evenly, within its digits, and is not the number of the row."""
    steps = np.diff(column.values)
    if len(steps) < _LEAST_ROWS or not np.all(steps > 0.0) or _is_row_number(column):
        return False
    # rounded to its digits a step is off by up to one unit of the last one; a clock jitters by less than half a step
    return bool(np.ptp(steps) < np.median(steps))


def _is_row_number(column: SniffedColumn) -> bool:
    return len(column.values) > 1 and bool(np.all(np.diff(column.values) == 1.0)) and column.values[0] in (0.0, 1.0)


def _of_log(columns: Sequence[SniffedColumn], chain: Chain | None) -> Roles:
    """Return what instruments logged over time, where the columns can be cut into their signals in one way alone."""
    cuts = list(_cuts(tuple(columns), chain, ()))
    if not cuts:  # flags and the like
        cuts = list(_cuts(tuple(column for column in columns if column.size > 0.0), chain, ()))
    return _roles_of(cuts[0]) if len(cuts) == 1 else Roles()


_Part = tuple[str, tuple[SniffedColumn, ...]]
_JOINTS, _FORCE, _WRENCH, _PLACE = "joints", "force", "wrench", "place"


def _cuts(columns: tuple[SniffedColumn, ...], chain: Chain | None, before: tuple[_Part, ...]) -> Iterator[list[_Part]]:
    """Yield the ways to cut columns into joints, a force or wrench, and a place, each there at most once."""
    if not columns:
        if before:
            yield list(before)
        return
    kinds = {kind for kind, _ in before}
    sizes = [(_FORCE, 3), (_WRENCH, 6)] if not kinds & {_FORCE, _WRENCH} else []
    sizes += [(_PLACE, 3)] if _PLACE not in kinds else []
    counts = _USUAL_JOINTS if chain is None else (chain.n_joints,)
    sizes += [(_JOINTS, count) for count in counts] if _JOINTS not in kinds else []
    for kind, size in sizes:
        part = columns[:size]
        if len(part) == size and _can_be(kind, part, chain):
            yield from _cuts(columns[size:], chain, (*before, (kind, part)))


def _can_be(kind: str, columns: tuple[SniffedColumn, ...], chain: Chain | None) -> bool:
    values = numbers_of(columns)
    travel, middle = np.ptp(values, axis=0), np.abs(values.mean(axis=0))
    if kind in (_FORCE, _WRENCH):  # zeroed at the beginning, and too large for a displacement in mm
        begins = np.abs(values[:_FIRST_ROWS].mean(axis=0))
        zeroed = bool(np.linalg.norm(begins[:3]) < UNLOADED * np.linalg.norm(travel[:3]))
        of_moments = kind == _FORCE or bool(np.linalg.norm(begins[3:]) < UNLOADED * np.linalg.norm(travel[3:]))
        return zeroed and of_moments and bool(np.abs(values[:, :3]).max() > LARGEST_DEFLECTION_MM)
    if not float(np.linalg.norm(travel)) < _STANDS * float(np.linalg.norm(middle)):
        return False
    if kind == _PLACE:
        return bool(np.any(travel > 0.0))
    if chain is not None:
        return within_limits(columns, chain)
    return LARGEST_RADIAN < float(np.abs(values).max()) <= _LARGEST_ANGLE_DEG


def _roles_of(parts: Sequence[_Part]) -> Roles:
    found = dict(parts)
    zeroed = "begins at zero, and is too large for a displacement"
    force = found.get(_FORCE) or found.get(_WRENCH, ())
    return Roles(
        joints=_role(found.get(_JOINTS, ()), "angles of one pose"),
        force=_role(force[:3], zeroed),
        moment=_role(force[3:], zeroed),
        position=_role(found.get(_PLACE, ()), "far from zero, and hardly moves"),
    )


def _role(columns: tuple[SniffedColumn, ...], why: str) -> Role | None:
    return Role(columns, doubt=why) if columns else None


def open_columns(roles: Roles) -> list[str]:
    """Return a sentence on each column without a name that changes and is used for nothing."""
    return [
        f"{column.header} ({min(column.values):.4g} to {max(column.values):.4g}) is not used: its values leave open "
        "what it is"
        for column in roles.unused
        if _NUMBERED.fullmatch(column.header) and len(set(column.values)) > 1 and not _is_row_number(column)
    ]
