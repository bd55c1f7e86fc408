"""Text exports of Beckhoff's TwinCAT Scope: rows of properties, each channel with a time column before it.

Above the data stand rows such as ``Name⇥A1⇥Name⇥A2``, ``SampleTime[ms]⇥1⇥SampleTime[ms]⇥1``, ``Unit⇥deg⇥Unit⇥deg``. The
property's name stands where the data have times (in ms): before each channel, or before those that share a time column.

Source: Beckhoff TE13xx, TwinCAT 3 Scope View, "Export in csv".
"""

from __future__ import annotations

from collections.abc import Sequence

NAME = "Name"
PROPERTIES = frozenset(
    (
        *(NAME, "SymbolComment", "Data-Type", "SampleTime[ms]", "VariableSize", "SymbolBased", "IndexGroup", "Unit"),
        *("IndexOffset", "SymbolName", "NetID", "NetId", "Port", "Offset", "ScaleFactor", "BitMask"),
        *("Unit ScaleFactor", "Unit Offset", "StartTime", "EndTime"),
    )
)
TIME = "time"
TIME_UNIT = "ms"


def is_scope_header(names: Sequence[str], below: Sequence[str]) -> bool:
    """Return True for the row of channel names, by the row below it: another property at the same places."""
    return (
        len(names) > 1
        and names[0] == NAME
        and bool(below)
        and below[0] in PROPERTIES - {NAME}
        and all((name == NAME) == (word == below[0]) for name, word in zip(names, below, strict=False))
    )


def scope_columns(names: Sequence[str]) -> tuple[str, ...]:
    """Return the columns' names: the channels, and ``time`` or, where there are several, ``time CHANNEL``.

    Examples
    --------
    >>> scope_columns(["Name", "A1", "Name", "A2"])
    ('time A1', 'A1', 'time A2', 'A2')
    >>> scope_columns(["Name", "A1", "A2"])
    ('time', 'A1', 'A2')
    """
    alone = list(names).count(NAME) == 1
    following = [*names[1:], ""]
    return tuple(
        name if name != NAME else TIME if alone else f"{TIME} {channel}".strip()
        for name, channel in zip(names, following, strict=True)
    )


def scope_units(names: Sequence[str], columns: Sequence[str], units: Sequence[str]) -> dict[str, str]:
    """Return column to unit, from the cells of the row ``Unit``: ``deg``, ``V (Voltage)``, ``(None)``."""
    unit_of = {column: TIME_UNIT for name, column in zip(names, columns, strict=True) if name == NAME}
    for name, column, unit in zip(names, columns, units, strict=False):
        bare = unit.split("(")[0].strip()
        if name != NAME and bare:
            unit_of[column] = bare
    return unit_of
