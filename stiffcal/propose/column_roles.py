"""What columns of a table are: those of one signal, and all signals of a table."""

from __future__ import annotations

from dataclasses import dataclass, field

from stiffcal.propose.place_columns import SigmaColumns
from stiffcal.propose.table_sniffing import SniffedColumn


@dataclass(frozen=True)
class Role:
    """The columns of one signal."""

    columns: tuple[SniffedColumn, ...]
    """In order."""
    places: frozenset[str] = frozenset()
    """Words in the names that say where ("base", "tool", …)."""
    sigma: SigmaColumns | None = None
    """The uncertainty of each reading, where the table holds it."""
    is_open: bool = False
    """Whether names and missing units leave open what the columns hold."""
    body: str = ""
    """What is measured, as the names call it; "" where they name nothing."""
    others: tuple[str, ...] = ()
    """Other bodies whose columns hold the same."""
    doubt: str = ""
    """What is open about the columns; "" where nothing is."""

    @property
    def stands_still(self) -> bool:
        """Whether no value changes over the rows: of an orientation that was not measured, as noise moves others."""
        return all(len(column.values) > 1 and len(set(column.values)) == 1 for column in self.columns)

    @property
    def all_columns(self) -> tuple[SniffedColumn, ...]:
        """The columns, and those of their uncertainty."""
        return self.columns + (self.sigma.columns if self.sigma is not None else ())


@dataclass(frozen=True)
class Roles:
    """Columns recognised in a table, by signal; None where there are none."""

    joints: Role | None = None
    force: Role | None = None
    moment: Role | None = None
    deflection: Role | None = None
    rotation: Role | None = None
    position: Role | None = None
    quaternion: Role | None = None
    matrix: Role | None = None
    """Nine elements of a rotation matrix, row by row."""
    mass: Role | None = None
    run: SniffedColumn | None = None
    """The column of the runs' names."""
    time: SniffedColumn | None = None
    """The column of the time."""
    time_fraction: tuple[SniffedColumn, str] | None = None
    """The column of what is added to it, and its unit: nanoseconds next to seconds."""
    targets: tuple[tuple[str, Role], ...] = ()
    """Where places of several targets are measured: each with its name, `position` is the first. Otherwise empty."""
    unused: tuple[SniffedColumn, ...] = field(default=())
    """Columns that were not recognised."""


def holds_signals(roles: Roles) -> bool:
    """Return whether any signal is recognised: joints, a load, a displacement or a place."""
    signals = (roles.joints, roles.force, roles.mass, roles.deflection, roles.position)
    return any(role is not None for role in signals)
