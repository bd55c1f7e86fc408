"""Which columns of a log hold a drive's angle, velocity, torque and current, and which the temperature and the time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.recognising import recognise
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.quantities import UnknownUnitError, unit

POSITION, VELOCITY, TORQUE, CURRENT = "position", "velocity", "torque", "current"
TEMPERATURE, TIME = "temperature", "time"

# Words that name a quantity, in the order in which they are looked for; a unit in the header outweighs them.
_WORDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        VELOCITY: ("velocity", "vel", "speed", "omega", "qd", "dq", "v", "w", "geschwindigkeit", "drehzahl"),
        TORQUE: ("torque", "trq", "tq", "tau", "moment", "drehmoment", "effort", "eff"),
        CURRENT: ("current", "curr", "cur", "strom", "i", "iq"),
        TEMPERATURE: ("temperature", "temp", "temperatur"),
        TIME: ("time", "zeit", "timestamp", "zeitstempel", "elapsedtime", "datetime"),
        POSITION: ("angle", "position", "pos", "winkel", "encoder", "theta", "th", "phi", "q"),
    }
)
# A column of these words alone, and a number, is a joint's angle.
_JOINT_WORDS = ("a", "axis", "achse", "axe", "j", "joint", "gelenk")
_MOTOR_WORDS = ("motor", "m", "mot")
_FILLERS = ("act", "actual", "is", "ist", "meas", "measured")
_NOT_MEASURED = (
    "command",
    "commanded",
    "cmd",
    "control",
    "soll",
    "target",
    "setpoint",
    "ref",
    "desired",
    "des",
    "goal",
)
_QUANTITIES = {POSITION: "angle", VELOCITY: "velocity", TORQUE: "torque", CURRENT: "current",
               TEMPERATURE: "temperature", TIME: "time"}  # fmt: skip


@dataclass(frozen=True)
class DriveColumns:
    """What the columns of a log of drives are."""

    signals: Mapping[str, tuple[SniffedColumn, ...]]
    """Of the joints, base to tip: columns of ``position``, ``velocity``, ``torque``, ``current``, as far as logged."""
    motor: bool
    """Whether the names of these columns mention a motor."""
    wrench: Roles
    """Force and moment of a sensor, where there are any."""
    temperature: tuple[SniffedColumn, ...]
    """Of each sensor."""
    time: SniffedColumn | None
    """None where no column is recognised as the time."""
    unused: tuple[SniffedColumn, ...]
    """Columns that were not recognised."""


@dataclass(frozen=True)
class _NamedColumn:
    """A column, and what its name and unit make it."""

    column: SniffedColumn
    quantity: str | None
    number: int | None
    """Of the joint; None where the name holds no number."""
    group: str
    """The name without the number: equal for the columns of all joints."""
    motor: bool


def drive_columns(columns: Iterable[SniffedColumn], joint_columns: Sequence[SniffedColumn] = ()) -> DriveColumns:
    """Recognise the columns of a log of one drive or of all drives of a robot.

    Parameters
    ----------
    columns : of the log.
    joint_columns : those of the joint angles, base to tip, where they are known by the robot's names.

    Examples
    --------
    >>> log = [SniffedColumn(name, name, None, (0.0,)) for name in ("t", "J1", "J2", "J1_torque", "J2_torque", "T")]
    >>> found = drive_columns(log)
    >>> {signal: [column.header for column in found.signals[signal]] for signal in found.signals}
    {'position': ['J1', 'J2'], 'torque': ['J1_torque', 'J2_torque']}
    >>> found.time.header, [column.header for column in found.temperature]
    ('t', ['T'])
    """
    numeric = [column for column in columns if column.values]
    wrench = _wrench_of(numeric)
    in_wrench = {column for role in (wrench.force, wrench.moment) if role is not None for column in role.columns}
    named = [_named(column) for column in numeric if column not in in_wrench and column not in joint_columns]
    time = next((entry.column for entry in named if entry.quantity == TIME), None)
    time = time or next((entry.column for name in ("t", "T") for entry in named if entry.column.name == name), None)
    temperature = tuple(
        entry.column
        for entry in named
        if entry.column is not time and (entry.quantity == TEMPERATURE or (not entry.quantity and entry.group == "t"))
    )
    signals: dict[str, tuple[SniffedColumn, ...]] = {POSITION: tuple(joint_columns)} if joint_columns else {}
    motor = False
    for quantity in (POSITION, VELOCITY, TORQUE, CURRENT):
        group = _group_of(named, quantity, len(next(iter(signals.values()), ())))
        if group and quantity not in signals:
            signals[quantity] = tuple(entry.column for entry in group)
            motor = motor or any(entry.motor for entry in group)
    used = {*in_wrench, *temperature, *(column for group in signals.values() for column in group), time}
    unused = tuple(column for column in columns if column not in used)
    return DriveColumns(signals, motor, wrench, temperature, time, unused)


def _wrench_of(columns: Sequence[SniffedColumn]) -> Roles:
    roles = recognise(columns)
    if roles.force is None:
        return Roles()
    return Roles(force=roles.force, moment=roles.moment)


def _named(column: SniffedColumn) -> _NamedColumn:
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", column.name)
    words = re.findall(r"[^\W\d_]+|\d+", spaced.lower())
    numbers = [int(word) for word in words if word.isdigit() and len(word) <= 3]
    letters = [word for word in words if not word.isdigit()]
    motor = any(word in _MOTOR_WORDS for word in letters)
    quantity = None
    if not any(word in _NOT_MEASURED for word in letters):
        quantity = _quantity(column, letters, bool(numbers))
    return _NamedColumn(column, quantity, numbers[0] if len(numbers) == 1 else None, "".join(letters), motor)


def _quantity(column: SniffedColumn, letters: Sequence[str], numbered: bool) -> str | None:
    if column.unit is not None:
        return next((name for name, asked in _QUANTITIES.items() if _has_unit(column.unit, asked)), None)
    by_word = next((name for name, words in _WORDS.items() if any(word in words for word in letters)), None)
    if by_word is not None or not numbered:
        return by_word
    if all(word in (*_JOINT_WORDS, *_MOTOR_WORDS, *_FILLERS) for word in letters):
        return POSITION
    return TORQUE if letters == ["t"] else None


def _has_unit(written: str, quantity: str) -> bool:
    if quantity == TIME and written == "iso8601":
        return True
    try:
        unit(written, quantity)
    except UnknownUnitError:
        return False
    return True


def _group_of(named: Sequence[_NamedColumn], quantity: str, count: int) -> list[_NamedColumn]:
    """Return the columns of a quantity, one for each joint: numbered without a gap, or a single one.

    Parameters
    ----------
    count : how many joints other signals have; 0: not known yet, the largest group is taken.
    """
    groups: dict[str, list[_NamedColumn]] = {}
    for entry in named:
        if entry.quantity == quantity:
            groups.setdefault(entry.group, []).append(entry)
    complete = []
    for group in groups.values():
        numbers = [entry.number for entry in group if entry.number is not None]
        in_order = sorted(group, key=lambda entry: entry.number or 0)
        gapless = len(numbers) == len(group) and sorted(numbers) in (
            list(range(1, len(group) + 1)),
            list(range(len(group))),
        )
        if (len(group) == 1 or gapless) and count in (0, len(group)):
            complete.append(in_order)
    complete.sort(key=lambda group: (-len(group), group[0].motor))
    return complete[0] if complete else []


def as_roles(drives: DriveColumns) -> Roles:
    """Return the joints' angles, or what else of them is logged, as the signal that a robot is compared with."""
    first = next(iter(drives.signals.values()), ())
    return Roles(joints=Role(tuple(first)), force=drives.wrench.force, moment=drives.wrench.moment)
