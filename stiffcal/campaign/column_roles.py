"""What the columns of a table are, by their names: joints, force, moment, displacement, position, run, time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from stiffcal.campaign.place_columns import SigmaColumns, numbered_targets, sigma_columns, sigma_of, single_target
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
    keys = {column.header: _key(column.name) for column in columns}
    plain = {column.header: keys[column.header][0] for column in columns}
    quaternion = _quaternion(columns, plain)
    assigned = set(quaternion.columns) if quaternion is not None else set()
    joints = Role(tuple(joint_columns)) if joint_columns else None
    joints = joints or _joints([column for column in columns if column not in assigned], plain)
    assigned |= set(joints.columns) if joints is not None else set()
    sigma = sigma_columns({column: _words(column.name)[0] for column in columns if column not in assigned})
    free = [column for column in columns if column.values and column not in (assigned | set(sigma.values()))]
    triples = _triples(free, keys)
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
    time = _single([column for column in columns if column.values and column not in assigned], plain, _TIMES)
    mass = _single([column for column in columns if column.values and column not in assigned], plain, _MASSES)
    further = [role for _, role in targets]
    roles = [role for role in (joints, quaternion, *triples.values(), *further) if role is not None]
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


def _key(name: str) -> tuple[str, frozenset[str]]:
    """Take a name apart: the bare word in small letters, and the words that say where."""
    kept, places = _words(name)
    return "".join(kept), places


def _words(name: str) -> tuple[list[str], frozenset[str]]:
    """Take a name apart: its words in small letters, and those among them that say where."""
    words = [word for word in re.split(r"[^A-Za-z0-9]+", name.lower()) if word]
    places = frozenset(word for word in words if word in _PLACES)
    return [word for word in words if word not in places], places


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
