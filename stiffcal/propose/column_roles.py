"""What the columns of a table are, by their names: joints, force, moment, displacement, position, run, time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from stiffcal.campaign.column_names import (
    QUATERNIONS,
    STEMS,
    TIMES,
    Component,
    Reading,
    component_of,
    numbered_joints,
    plain_name,
    words_of,
)
from stiffcal.propose.place_columns import SigmaColumns, numbered_targets, sigma_columns, sigma_of, single_target
from stiffcal.propose.table_sniffing import SniffedColumn

_RUNS = ("run", "lauf", "pose", "versuch", "series", "config", "configuration", "messung", "runid", "poseid")
_MASSES = ("kg", "mass", "masse", "weight", "gewicht", "payload", "payloadmass", "nutzlast", "traglast")


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
    mass: Role | None = None
    run: SniffedColumn | None = None
    """The column of the runs' names."""
    time: SniffedColumn | None = None
    """The column of the time."""
    targets: tuple[tuple[str, Role], ...] = ()
    """Where places of several targets are measured: each with its name, `position` is the first. Otherwise empty."""
    unused: tuple[SniffedColumn, ...] = field(default=())
    """Columns that were not recognised."""


def recognise(columns: Iterable[SniffedColumn], joint_columns: Sequence[SniffedColumn] = ()) -> Roles:
    """Recognise the columns of a table by their names.

    Parameters
    ----------
    columns : of the table.
    joint_columns : those of the joints, base to tip, where they are known by the robot's names.

    Examples
    --------
    >>> names = ["theta1", "theta2", "theta3", "Base_Fx", "Base_Fy", "Base_Fz", "note"]
    >>> found = recognise(SniffedColumn(name, name, None, (0.0,)) for name in names)
    >>> len(found.joints.columns), sorted(found.force.places), [column.name for column in found.unused]
    (3, ['base'], ['note'])
    """
    columns = tuple(columns)
    plain = {column.header: plain_name(column.name) for column in columns}
    quaternion = _quaternion(columns, plain)
    assigned = set(quaternion.columns) if quaternion is not None else set()
    joints = Role(tuple(joint_columns)) if joint_columns else None
    joints = joints or _joints([column for column in columns if column not in assigned])
    assigned |= set(joints.columns) if joints is not None else set()
    sigma = sigma_columns({column: words_of(column.name)[0] for column in columns if column not in assigned})
    free = [column for column in columns if column.values and column not in (assigned | set(sigma.values()))]
    triples = _triples(free)
    targets = _targets(free, plain) if quaternion is None and "deflection" not in triples else ()
    triples |= {"position": targets[0][1]} if targets else {}
    if not triples.keys() & {"position", "deflection"} and (
        only := single_target({column: plain[column.header] for column in free})
    ):
        triples["position"] = Role(only)
    targets = tuple((name, _with_sigma(role, plain, sigma)) for name, role in targets)
    for signal in ("deflection", "position"):
        if signal in triples:
            triples[signal] = _with_sigma(triples[signal], plain, sigma, of_all=signal == "position")
    assigned |= set(sigma.values())
    run = _single([column for column in columns if column not in assigned], plain, _RUNS)
    time = _single([column for column in columns if column.values and column not in assigned], plain, TIMES)
    mass = _single([column for column in columns if column.values and column not in assigned], plain, _MASSES)
    further = [role for _, role in targets]
    # a rotation belongs to a displacement; next to a place it is written in too many ways to be taken
    taken = [role for name, role in triples.items() if name != Reading.ROTATION or Reading.DEFLECTION in triples]
    roles = [role for role in (joints, quaternion, *taken, *further) if role is not None]
    used = {column for role in roles for column in role.all_columns} | {c for c in (run, time, mass) if c is not None}
    return Roles(
        joints=joints,
        quaternion=quaternion,
        mass=None if mass is None else Role((mass,)),
        run=run,
        time=time,
        targets=targets,
        unused=tuple(column for column in columns if column not in used),
        **triples,
    )


def _targets(columns: list[SniffedColumn], plain: dict[str, str]) -> tuple[tuple[str, Role], ...]:
    """Return the targets of a table that measures several, each with its name; empty where it does not."""
    return tuple(
        (target.name, Role(target.columns))
        for target in numbered_targets({column: plain[column.header] for column in columns})
    )


def _with_sigma(role: Role, plain: dict[str, str], sigma: dict[str, SniffedColumn], of_all: bool = True) -> Role:
    """Return a role of three readings with the columns of their uncertainty, where there are any."""
    names = [plain[column.header] for column in role.columns]
    return replace(role, sigma=sigma_of(names, sigma, of_all))


def _joints(columns: list[SniffedColumn]) -> Role | None:
    """Find the numbered columns of the joints."""
    of_name = {column.name: column for column in columns if column.values}
    names = numbered_joints(list(of_name))
    return Role(tuple(of_name[name] for name in names)) if names else None


def _triples(columns: list[SniffedColumn]) -> dict[str, Role]:
    """Find the groups of three columns x, y and z."""
    groups: dict[tuple[Reading, str, frozenset[str]], dict[int, tuple[SniffedColumn, Component]]] = {}
    for column in columns:
        found = component_of(column.name, column.unit)
        if found is not None:
            groups.setdefault((found.reading, found.stem, found.places), {})[found.axis] = column, found
    roles: dict[str, Role] = {}
    for reading, stems in STEMS.items():
        ordered = sorted(
            (group for (own, _, _), group in groups.items() if own is reading and len(group) == 3),
            key=lambda group: _rank(group[0][1].stem, stems),
        )
        if ordered:
            group = ordered[0]
            is_open = group[0][1].is_open
            roles[reading] = Role(tuple(group[k][0] for k in range(3)), group[0][1].places, is_open=is_open)
    return roles


def _rank(stem: str, stems: tuple[str, ...]) -> int:
    return stems.index(stem if stem in stems else "target")


def _quaternion(columns: tuple[SniffedColumn, ...], plain: dict[str, str]) -> Role | None:
    by_name = {plain[column.header]: column for column in columns}
    for names in QUATERNIONS:
        if all(name in by_name for name in names):
            return Role(tuple(by_name[name] for name in names))
    return None


def _single(columns: list[SniffedColumn], plain: dict[str, str], names: tuple[str, ...]) -> SniffedColumn | None:
    for name in names:
        for column in columns:
            if plain[column.header] == name:
                return column
    return None
