"""What the columns of a table are, by their names: joints, force, moment, displacement, position, run, time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from stiffcal.campaign.columns.column_headers import is_unit_of
from stiffcal.campaign.columns.column_names import (
    QUANTITY,
    STEMS,
    TRAVEL,
    Component,
    Reading,
    component_of,
    components_of_arrays,
)
from stiffcal.campaign.columns.column_words import DATES, FRACTIONS, MEASURED_AT, TIMES, plain_name, words_of
from stiffcal.campaign.columns.joint_names import numbered_joints
from stiffcal.campaign.manifest.source import TIMES_IN_WORDS
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.orientation_columns import matrix_of, quaternion_of, transformation_of
from stiffcal.propose.place_columns import numbered_targets, sigma_columns, sigma_of, single_target
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.propose.time_lines import stands_still
from stiffcal.quantities import unit

_RUNS = (
    *("run", "lauf", "essai", "ensayo", "prova", "pose", "versuch", "series", "config", "configuration", "messung"),
    *("runid", "poseid"),
)
_MASSES = ("kg", "mass", "masse", "weight", "gewicht", "payload", "payloadmass", "nutzlast", "traglast")


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
    every = tuple(columns)
    columns = tuple(column for column in every if not is_computed(column.header))
    plain = {column.header: plain_name(column.name) for column in columns}
    quaternion = quaternion_of(columns, plain)
    assigned = set(quaternion.columns) if quaternion is not None else set()
    joints = Role(tuple(joint_columns)) if joint_columns else None
    joints = joints or _joints([column for column in columns if column not in assigned])
    assigned |= set(joints.columns) if joints is not None else set()
    transform = transformation_of([column for column in columns if column not in assigned], plain)
    matrix, place = transform or (matrix_of([column for column in columns if column not in assigned], plain), None)
    assigned |= {column for role in (matrix, place) if role is not None for column in role.columns}
    sigma = sigma_columns({column: words_of(column.name)[0] for column in columns if column not in assigned})
    triples, targets = _measured(columns, assigned | set(sigma.values()), plain, quaternion, matrix, place)
    if sigma and not triples.keys() & _MEASURED:  # of nothing: "ux" is a displacement
        sigma = {}
        triples, targets = _measured(columns, assigned, plain, quaternion, matrix, place)
    targets = tuple((name, _with_sigma(role, plain, sigma)) for name, role in targets)
    for signal in ("deflection", "position"):
        if signal in triples:
            triples[signal] = _with_sigma(triples[signal], plain, sigma, of_all=signal == "position")
    assigned |= set(sigma.values())
    run = _single([column for column in columns if column not in assigned], plain, _RUNS)
    left = [column for column in columns if column.values and column not in assigned]
    # when it was measured, rather than when a recorder took it: not every driver fills it in
    stamps = [column for column in left if any(column.values)]
    time = _single(stamps, plain, (MEASURED_AT,)) or _single(left, plain, TIMES) or _among_words(left)
    fraction = _fraction_of(time, left)
    mass = _single([column for column in columns if column.values and column not in assigned], plain, _MASSES)
    further = [role for _, role in targets]
    # a rotation belongs to a displacement; next to a place it is written in too many ways to be taken
    taken = [role for name, role in triples.items() if name != Reading.ROTATION or Reading.DEFLECTION in triples]
    roles = [role for role in (joints, quaternion, matrix, *taken, *further) if role is not None]
    single = (run, time, mass, fraction[0] if fraction is not None else None)
    used = {column for role in roles for column in role.all_columns} | {
        column for column in single if column is not None
    }
    return Roles(
        joints=joints,
        quaternion=quaternion,
        matrix=matrix,
        mass=None if mass is None else Role((mass,)),
        run=run,
        time=time,
        time_fraction=fraction,
        targets=targets,
        unused=tuple(column for column in every if column not in used),
        **triples,
    )


_MEASURED = frozenset((Reading.DEFLECTION, Reading.POSITION))


def _measured(
    columns: Sequence[SniffedColumn],
    assigned: set[SniffedColumn],
    plain: dict[str, str],
    quaternion: Role | None,
    matrix: Role | None,
    place: Role | None,
) -> tuple[dict[str, Role], tuple[tuple[str, Role], ...]]:
    """Return the groups of three columns x, y and z, and the targets of which there are several."""
    free = [column for column in columns if column.values and column not in assigned]
    turned = quaternion or matrix
    triples = _triples(free, turned.body if turned is not None else "")
    triples |= {} if place is None else {Reading.POSITION: place}
    targets = _targets(free, plain) if quaternion is None and Reading.DEFLECTION not in triples else ()
    triples |= {Reading.POSITION: targets[0][1]} if targets else {}
    only = () if triples.keys() & _MEASURED else single_target({column: plain[column.header] for column in free})
    return triples | ({Reading.POSITION: Role(only)} if only else {}), targets


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


_Group = dict[int, tuple[SniffedColumn, Component]]
"""By axis the columns of one reading of one body."""


def _triples(columns: list[SniffedColumn], body: str) -> dict[str, Role]:
    """Find the groups of three columns x, y and z; of several bodies that with an orientation, else the first."""
    groups: dict[tuple[object, ...], _Group] = {}
    twice: set[tuple[object, ...]] = set()
    of_arrays = components_of_arrays([column.name for column in columns])
    for column in columns:
        found = component_of(of_arrays.get(column.name, column.name), column.unit)
        if found is not None:
            key = (found.reading, found.stem, found.places, found.body, found.doubt)
            if found.axis in groups.setdefault(key, {}):
                twice.add(key)  # of which of them the other two axes are is not known
            groups[key][found.axis] = column, found
    complete = [
        (group[0][1].reading, group)
        for key, group in groups.items()
        if len(group) == 3 and key not in twice and not _only_travels(group)
    ]
    of_reading: dict[Reading, list[Role]] = {}
    for reading, group in sorted(complete, key=_order):
        first = group[0][1]
        three = tuple(group[k][0] for k in range(3))
        role = Role(three, first.places, is_open=first.is_open, body=first.body, doubt=first.doubt)
        meant = _read_as(reading, role, first.stem, complete)
        if meant is Reading.POSITION and three[0].unit is None and not role.doubt:
            role = replace(role, doubt=_DOUBTS.get(first.stem, ""))
        of_reading.setdefault(meant, []).append(role)
    roles: dict[str, Role] = {}
    for reading, own in of_reading.items():
        chosen = next((role for role in own if body and role.body == body), own[0])
        others = tuple(role.body for role in own if role.body and role.body != chosen.body)
        roles[reading] = replace(chosen, others=others)
    return roles


# A displacement under load is smaller, in the unit that makes most of it: what is larger is a place.
_LARGEST_DISPLACEMENT_M = 0.05
# Around a sensor no force acts further away, so that no moment is larger; m.
_LONGEST_LEVER_M = 10.0
_DOUBTS = {"t": "positions, or moments in N*mm"}


def _only_travels(group: _Group) -> bool:
    """Return whether three columns that may be displacements or travels of axes are too large for displacements."""
    written = group[0][0].unit or "mm"
    if group[0][1].doubt != TRAVEL or not is_unit_of(written, "translation"):
        return False
    return max(column.size for column, _ in group.values()) * unit(written, "length").factor > _LARGEST_DISPLACEMENT_M


def _read_as(reading: Reading, role: Role, stem: str, complete: list[tuple[Reading, _Group]]) -> Reading:
    """Return what three columns hold where "Tx" may be a translation (trackers) or a torque (force sensors).

    Without a force next to it, and where it is too large for the force, it is a place; with a unit of length as well,
    where it is too large for a displacement.
    """
    if stem != "t":
        return reading
    size = max(column.size for column in role.columns)
    if reading is Reading.DEFLECTION:
        written = role.columns[0].unit or "mm"
        metres = size * unit(written, QUANTITY[reading]).factor
        return Reading.POSITION if metres > _LARGEST_DISPLACEMENT_M else reading
    if reading is Reading.MOMENT and role.columns[0].unit is None:
        forces = [max(group[k][0].size for k in range(3)) for own, group in complete if own is Reading.FORCE]
        if not forces or size > _LONGEST_LEVER_M * max(forces) > 0.0:
            return Reading.POSITION
    return reading


def _order(entry: tuple[Reading, _Group]) -> tuple[bool, bool, int]:
    """Return by what groups are sorted: what moves first, then what is in no doubt, then as their stems are listed."""
    reading, group = entry
    still = all(len(set(column.values)) < 2 for column, _ in group.values())
    return still, bool(group[0][1].doubt), _rank(group[0][1].stem, STEMS[reading])


def _rank(stem: str, stems: tuple[str, ...]) -> int:
    return stems.index(stem if stem in stems else "target")


def _among_words(columns: list[SniffedColumn]) -> SniffedColumn | None:
    """Return the first column that grows from row to row and has a word for time in its name, or alone a unit of it."""
    timed = [column for column in columns if column.unit is not None and is_unit_of(column.unit, "time")]
    for column in columns:
        words = words_of(column.name)[0]
        for_time = (word in DATES or (word in TIMES and len(word) >= _LEAST_WORD) for word in words)
        in_time = column.unit is not None and is_unit_of(column.unit, "time") and len(timed) == 1
        if _OF_A_STATE & set(words) or not (in_time or any(for_time)):
            continue
        if len(column.values) >= _LEAST_GROWING and not stands_still(column):
            return column
    return None


def _fraction_of(time: SniffedColumn | None, columns: list[SniffedColumn]) -> tuple[SniffedColumn, str] | None:
    """Return the column of what is added to a time that repeats its seconds, and its unit; None where there is none."""
    if time is None or not stands_still(time):
        return None
    for column in columns:
        last = (words_of(column.header)[0] or [""])[-1]
        written = next((name for name, words in FRACTIONS.items() if last in words), None)
        if column is time or written is None or len(column.values) != len(time.values):
            continue
        factor = unit(written, "time").factor
        whole = 1.0 if time.unit in TIMES_IN_WORDS or time.unit is None else unit(time.unit, "time").factor
        moments = [whole * own + factor * more for own, more in zip(time.values, column.values, strict=True)]
        if min(column.values) >= 0.0 and factor * max(column.values) < 1.0 and sorted(set(moments)) == moments:
            return column, written
    return None


_LEAST_WORD = 4  # letters: "time", "zeit"; what is shorter is a part of another name
_LEAST_GROWING = 3
_OF_A_STATE = frozenset(("hold", "held", "dwell", "halte", "haltezeit", "settling", "cycle", "step", "delta", "ramp"))
"""What a time of each load state is called."""


def _single(columns: list[SniffedColumn], plain: dict[str, str], names: tuple[str, ...]) -> SniffedColumn | None:
    for name in names:
        for column in columns:
            if name in (plain[column.header], column.name.strip().lower()):  # "čas" is a time, "cas" a case
                return column
    return None


_COMPUTED = re.compile(
    r"(?:(?:actual|target)_TCP_(?:pose|speed)|O_T_EE(?:_[cd])?|F_T_(?:EE|NE)|NE_T_EE|EE_T_K|R(?:Ist|Sol)\.[XYZABC])(?![a-z])",
    re.IGNORECASE,
)


def is_computed(name: str) -> bool:
    """Return whether a column of a controller's log holds what it computes of the joints' angles, which is no reading.

    Of Universal Robots the pose of the tool (RTDE), of Franka the transformations between its frames (libfranka), of
    KUKA where it believes the tool to be and where it has to be (RSI).

    Examples
    --------
    >>> is_computed("actual_TCP_pose_0"), is_computed("O_T_EE[12]"), is_computed("actual_q_0")
    (True, True, False)
    """
    return _COMPUTED.match(name) is not None
