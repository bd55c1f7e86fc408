"""What each column of a table is taken for, in which unit and why; or why it is not used."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from stiffcal.campaign.columns.column_headers import is_unit_of
from stiffcal.campaign.columns.column_words import TIMES, plain_name, words_of
from stiffcal.errors import InputError
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.explained_column import ExplainedColumn, NotUsed
from stiffcal.propose.recognising import is_computed
from stiffcal.propose.role_units import unit_of_signal
from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable
from stiffcal.propose.time_lines import unit_of_time
from stiffcal.propose.unnamed_columns import are_numbered
from stiffcal.quantities import is_known
from stiffcal.wording import unused_columns

_SIGNALS = ("joints", "force", "moment", "mass", "deflection", "rotation", "position", "quaternion", "matrix")
_UNITLESS = ("quaternion", "matrix")
_COMMANDED = frozenset(
    ("cmd", "command", "commanded", "soll", "setpoint", "desired", "target", "goal", "reference", "consigne", "指令")
)
# libfranka writes q_d of the desired angles
_DESIRED = re.compile(r"(?:d?q|tau_J|dq)_d(?:\[\d\])?")
_FEWEST_TO_COUNT = 3
"""Rows that show that a column counts them."""


def unused_in_words(columns: Iterable[ExplainedColumn]) -> list[str]:
    """Return a sentence for each reason for which columns are not used, with the columns, each once."""
    by_reason: dict[NotUsed | str, dict[str, ExplainedColumn]] = {}
    for column in columns:
        if not column.taken_as:
            by_reason.setdefault(column.not_used or column.why, {}).setdefault(column.column, column)
    return [
        f"{sentence}: {next(iter(alike.values())).why}"
        for alike in by_reason.values()
        for sentence in unused_columns(list(alike))
    ]


def is_strain(column: SniffedColumn) -> bool:
    """Return whether a column's unit is one of strain."""
    return column.unit is not None and is_known(column.unit, "strain")


def explained(
    tables: Sequence[SniffedTable], roles: Roles, prismatic: Collection[SniffedColumn] = ()
) -> list[ExplainedColumn]:
    """Return every column of tables with what it is taken for.

    Parameters
    ----------
    tables : in order. roles : what their columns are. prismatic : columns that hold positions of prismatic joints.
    """
    taken = _taken(roles, prismatic)
    headers = [column.header for table in tables for column in table.columns]
    unnamed = [role for role in vars(roles).values() if isinstance(role, Role)] if are_numbered(headers) else []
    by_values = {column.header: f"its values: {role.doubt}" for role in unnamed for column in role.columns}
    found = []
    for table in tables:
        for column in table.columns:
            signal, unit, guessed = taken.get(column.header, ("", column.unit or "", False))
            not_used = None if signal else _not_used(column, roles, bool(unnamed))
            if not_used is not None:
                why = column.doubt if not_used is NotUsed.WORDS and column.doubt else not_used.value
            else:
                why = by_values.get(column.header, "its name")
                why += f"; {unit} by its values (up to {column.size:.4g})" if guessed else ", its unit" if unit else ""
            entry = ExplainedColumn(file=table.path.name, column=column.header, taken_as=signal, unit=unit, why=why)
            found.append(replace(entry, not_used=None if column.doubt else not_used))
        found += [
            ExplainedColumn(file=table.path.name, column=name, taken_as="", unit="", why=why)
            for name, why in table.left_out
        ]
    return found


def _taken(roles: Roles, prismatic: Collection[SniffedColumn]) -> Mapping[str, tuple[str, str, bool]]:
    """Return the columns that are used: what for, the unit, and whether that was guessed."""
    taken: dict[str, tuple[str, str, bool]] = {}
    entries = [(name, getattr(roles, name), name) for name in _SIGNALS]
    entries += [(f"position of {target}", role, "position") for target, role in roles.targets]
    for name, role, signal in entries:
        if not isinstance(role, Role) or (signal in _UNITLESS and role.stands_still):
            continue
        if signal == "rotation" and roles.deflection is None:
            continue  # it is written in too many ways next to a place
        for linear in (False, True):
            columns = tuple(column for column in role.columns if (column in prismatic) is linear)
            if columns:
                unit, guessed = _unit_of(Role(columns), signal, linear)
                taken |= {column.header: (name, unit, guessed) for column in columns}
        of_sigma = role.all_columns[len(role.columns) :]
        taken |= {column.header: (f"sigma of {name}", column.unit or "", False) for column in of_sigma}
    if roles.time is not None:
        taken[roles.time.header] = ("time", *unit_of_time(roles.time))
    if roles.time_fraction is not None:
        taken[roles.time_fraction[0].header] = ("time", roles.time_fraction[1], False)
    if roles.run is not None:
        taken[roles.run.header] = ("run", "", False)
    return taken


def _unit_of(role: Role, signal: str, prismatic: bool) -> tuple[str, bool]:
    if signal in _UNITLESS:
        return "", False
    try:
        return unit_of_signal(role, signal, prismatic=prismatic)
    except InputError:  # said where the lines are proposed
        return role.columns[0].unit or "", False


def _not_used(column: SniffedColumn, roles: Roles, unnamed: bool) -> NotUsed:
    """Return why a column is not used.

    Parameters
    ----------
    roles : what the columns of its table are. unnamed : whether these have no names.
    """
    words, values = words_of(column.name)[0], column.values
    still = [role for role in (roles.quaternion, roles.matrix) if role is not None and role.stands_still]
    others = () if roles.position is None else roles.position.others
    timed = plain_name(column.name) in TIMES or is_unit_of(column.unit or "", "time")
    counts = len(values) >= _FEWEST_TO_COUNT and all(later == before + 1.0 for before, later in pairwise(values))
    reasons = (
        (NotUsed.WORDS, not values),
        (NotUsed.STANDS_STILL, any(column in role.columns for role in still)),
        (NotUsed.LEFT_OPEN, unnamed),
        (NotUsed.STRAIN, is_strain(column)),
        (NotUsed.COMPUTED, is_computed(column.header)),
        (NotUsed.COMMANDED, bool(_COMMANDED.intersection(words)) or _DESIRED.fullmatch(column.header) is not None),
        (NotUsed.OTHER_BODY, any(other and " ".join(words).startswith(other) for other in others)),
        (NotUsed.TURN, roles.rotation is not None and column in roles.rotation.columns),
        (NotUsed.OTHER_TIME, roles.time is not None and timed),
        (NotUsed.COUNTER, counts),
    )
    return next((reason for reason, holds in reasons if holds), NotUsed.NO_SIGNAL)
