"""What each column of a table is taken for, in which unit and why; or why it is not taken."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from stiffcal.propose.column_roles import Role, Roles, is_computed
from stiffcal.propose.explained_column import ExplainedColumn
from stiffcal.propose.table_sniffing import SniffedColumn, SniffedTable
from stiffcal.propose.unnamed_columns import are_numbered
from stiffcal.quantities import is_known
from stiffcal.wording import unused_columns

_OF_RODS = "where each is fixed is in no table, stiffcal init DIR --kind ids shows what to write"
_COMPUTED = "the controller computes that from its joints' angles, it is no measurement"
_SIGNALS = ("joints", "force", "moment", "mass", "deflection", "rotation", "position", "quaternion", "matrix")


def unused_in_words(columns: Iterable[SniffedColumn]) -> list[str]:
    """Return sentences that name the columns which are not used, each once, of some with the reason.

    Examples
    --------
    >>> status = SniffedColumn("status", "status", None, (0.0,))
    >>> unused_in_words([status, status])
    ['column status is not used']
    """
    columns = list({column.header: column for column in columns}.values())
    strains = [column.header for column in columns if is_strain(column)]
    computed = [column.header for column in columns if is_computed(column.header)]
    others = [column.header for column in columns if column.header not in (*strains, *computed)]
    return [
        *unused_columns(others),
        *(f"{words}: strains are read of rods, and {_OF_RODS}" for words in unused_columns(strains)),
        *(f"{words}: {_COMPUTED}" for words in unused_columns(computed)),
    ]


def is_strain(column: SniffedColumn) -> bool:
    """Return whether a column's unit is one of strain."""
    return column.unit is not None and is_known(column.unit, "strain")


def explained(tables: Sequence[SniffedTable], roles: Roles) -> list[ExplainedColumn]:
    """Return every column of tables with what it is taken for.

    Parameters
    ----------
    tables : in order. roles : what their columns are.
    """
    taken: dict[str, str] = {}
    headers = [column.header for table in tables for column in table.columns]
    unnamed = [role for role in vars(roles).values() if isinstance(role, Role)] if are_numbered(headers) else []
    for name in _SIGNALS:
        role = getattr(roles, name)
        if isinstance(role, Role) and not (name in ("quaternion", "matrix") and role.stands_still):
            taken |= {column.header: name for column in role.columns}
            taken |= {column.header: f"sigma of {name}" for column in role.all_columns[len(role.columns) :]}
    reason_of = {column.header: f"its values: {role.doubt}" for role in unnamed for column in role.columns}
    if are_numbered(headers):
        reason_of |= {column.header: "its values leave open what it is" for column in roles.unused}
    for target, role in roles.targets:
        taken |= {column.header: f"position of {target}" for column in role.columns}
    taken |= {roles.time.header: "time"} if roles.time is not None else {}
    taken |= {roles.time_fraction[0].header: "time"} if roles.time_fraction is not None else {}
    taken |= {roles.run.header: "run"} if roles.run is not None else {}
    orientations = [role for role in (roles.quaternion, roles.matrix) if role is not None and role.stands_still]
    still = {column for role in orientations for column in role.columns}
    found = []
    for table in tables:
        for column in table.columns:
            signal = taken.get(column.header, "")
            by_name = (column.doubt or "it holds words") if not column.values else "its name is that of no signal"
            by_name = f"a strain is read of a rod: {_OF_RODS}" if is_strain(column) else by_name
            by_name = _COMPUTED if is_computed(column.header) else by_name
            by_name = "its name" if signal else by_name
            why = reason_of.get(column.header, by_name)
            why = "an orientation that never changes is not measured" if column in still else why
            why += ", its unit" if signal and column.unit is not None else ""
            found.append(
                ExplainedColumn(
                    file=table.path.name, column=column.header, taken_as=signal, unit=column.unit or "", why=why
                )
            )
        found += [
            ExplainedColumn(file=table.path.name, column=name, taken_as="", unit="", why=why)
            for name, why in table.left_out
        ]
    return found
