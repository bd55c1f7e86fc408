"""What the columns of a table are, by their names: joints, force, moment, displacement, position, run, time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from stiffcal.campaign.table_sniffing import SniffedColumn

# Words that say where, not what; they are noted and taken off the name.
_PLACES = ("base", "world", "robot", "tool", "tcp", "flange", "sensor", "ft", "mean", "avg")

_JOINT_STEMS = (
    *("a", "axis", "achse", "axe", "j", "joint", "q", "theta", "th", "gelenk", "angle", "winkel"),
    *("axisa", "axisacta", "axisact", "axisposact", "actualq", "actualj", "jointangle", "jointposition", "achsea"),
)
_TRIPLES = {
    "force": ("f", "force", "kraft", "load", "last"),
    "moment": ("t", "m", "torque", "moment", "drehmoment", "tau", "mom"),
    "deflection": ("d", "delta", "u", "disp", "displacement", "defl", "deflection", "verschiebung", "def"),
    "rotation": ("dr", "deltar", "drot", "rot", "r", "phi", "dphi"),
    "position": ("", "p", "pos", "position", "target", "point", "messpunkt", "measurement", "measured"),
}
# A tracked target, also one of several: the first that is complete is taken.
_TARGETS = re.compile(r"(led|marker|smr|reflector|reflektor|probe|tmac|tprobe|p|pt|point|punkt)\d*")
_QUATERNIONS = (("q0", "qx", "qy", "qz"), ("qw", "qx", "qy", "qz"), ("quatw", "quatx", "quaty", "quatz"))
_RUNS = ("run", "lauf", "pose", "versuch", "series", "config", "configuration", "messung", "runid", "poseid")
_TIMES = ("t", "time", "zeit", "timestamp", "zeitstempel", "datetime", "elapsedtime", "zeitpunkt")
_MASSES = ("kg", "mass", "masse", "weight", "gewicht")


@dataclass(frozen=True)
class Role:
    """The columns of one signal."""

    columns: tuple[SniffedColumn, ...]
    """In order."""
    places: frozenset[str] = frozenset()
    """Words in the names that say where ("base", "tool", …)."""


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
    keys = {column.header: _key(column.name) for column in columns}
    plain = {column.header: keys[column.header][0] for column in columns}
    quaternion = _quaternion(columns, plain)
    assigned = set(quaternion.columns) if quaternion is not None else set()
    joints = Role(tuple(joint_columns)) if joint_columns else None
    joints = joints or _joints([column for column in columns if column not in assigned], plain)
    assigned |= set(joints.columns) if joints is not None else set()
    triples = _triples([column for column in columns if column.values and column not in assigned], keys)
    run = _single([column for column in columns if column not in assigned], plain, _RUNS)
    time = _single([column for column in columns if column.values and column not in assigned], plain, _TIMES)
    mass = _single([column for column in columns if column.values and column not in assigned], plain, _MASSES)
    roles = [role for role in (joints, quaternion, *triples.values()) if role is not None]
    used = {column for role in roles for column in role.columns} | {c for c in (run, time, mass) if c is not None}
    return Roles(
        joints=joints,
        quaternion=quaternion,
        mass=None if mass is None else Role((mass,)),
        run=run,
        time=time,
        unused=tuple(column for column in columns if column not in used),
        **triples,
    )


def _key(name: str) -> tuple[str, frozenset[str]]:
    """Take a name apart: the bare word in small letters, and the words that say where."""
    words = [word for word in re.split(r"[^A-Za-z0-9]+", name.lower()) if word]
    places = frozenset(word for word in words if word in _PLACES)
    kept = [word for word in words if word not in places]
    return "".join(kept), places


def _joints(columns: list[SniffedColumn], plain: dict[str, str]) -> Role | None:
    """Find the columns numbered from 1 or 0 without a gap, three or more, with a stem that means joints."""
    groups: dict[str, dict[int, SniffedColumn]] = {}
    for column in columns:
        match = re.fullmatch(r"([a-z]*)0*(\d+)", plain[column.header])
        if match is not None and column.values:
            groups.setdefault(match[1], {})[int(match[2])] = column
    for stem in _JOINT_STEMS:
        group = groups.get(stem, {})
        if len(group) >= 3 and sorted(group) in (list(range(1, len(group) + 1)), list(range(len(group)))):
            return Role(tuple(group[number] for number in sorted(group)))
    return None


def _triples(columns: list[SniffedColumn], keys: dict[str, tuple[str, frozenset[str]]]) -> dict[str, Role]:
    """Find the groups of three columns that end in x, y and z."""
    groups: dict[tuple[str, frozenset[str]], dict[str, SniffedColumn]] = {}
    for column in columns:
        word, places = keys[column.header]
        if word and word[-1] in "xyz":
            groups.setdefault((word[:-1], places), {})[word[-1]] = column
    roles: dict[str, Role] = {}
    for role, stems in _TRIPLES.items():
        for stem in stems:
            for (word, places), group in groups.items():
                bare = _TARGETS.fullmatch(word)
                same = word == stem or (stem == "target" and bare is not None)
                if same and len(group) == 3 and role not in roles:
                    roles[role] = Role((group["x"], group["y"], group["z"]), places)
    return roles


def _quaternion(columns: tuple[SniffedColumn, ...], plain: dict[str, str]) -> Role | None:
    by_name = {plain[column.header]: column for column in columns}
    for names in _QUATERNIONS:
        if all(name in by_name for name in names):
            return Role(tuple(by_name[name] for name in names))
    return None


def _single(columns: list[SniffedColumn], plain: dict[str, str], names: tuple[str, ...]) -> SniffedColumn | None:
    for name in names:
        for column in columns:
            if plain[column.header] == name:
                return column
    return None
