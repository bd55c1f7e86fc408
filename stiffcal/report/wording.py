"""Numbers and names in the words of the people who read the report: mm, mrad, three significant digits.

Everything comes in SI units; what is not known is a dash, never a zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from stiffcal import wording
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where
from stiffcal.quantity import unit_words
from stiffcal.wording import (
    DASH,
    angle,
    count,
    in_unit,
    length,
    listing,
    percent,
    place,
    plus_minus,
    position,
    share,
    significant,
)

__all__ = [
    "DASH",
    "Placed",
    "angle",
    "capital",
    "count",
    "effect_at",
    "in_sheets",
    "in_unit",
    "length",
    "listing",
    "measure_cell",
    "measure_text",
    "part",
    "percent",
    "place",
    "plus_minus",
    "position",
    "share",
    "significant",
    "unit_words",
]


class Placed(Protocol):
    """A result that names an effect and its place."""

    @property
    def effect(self) -> str:
        """The effect's name."""

    @property
    def where(self) -> Where:
        """Its place."""


def size_of_effect(at_tool: float | None, torque: float | None) -> str:
    """Return the rms of an effect at the tool, m, or in a drive's torque, N·m; a dash where neither is known."""
    if torque:
        return f"{significant(torque, 2)} N·m"
    return length(at_tool) if at_tool else DASH


def measure_text(measure: Rms | Mapping[str, Any] | None) -> str:
    """Return translation and rotation of an error ``{translation, rotation, …}`` in one phrase; a dash for none.

    Examples
    --------
    >>> measure_text({"translation": 4.17e-5, "rotation": 7.79e-5})
    '0.0417 mm and 0.0779 mrad'
    >>> measure_text({"translation": 4.17e-5, "rotation": None}), measure_text(None)
    ('0.0417 mm', '–')
    """
    return listing(wording.measures(measure, " of the motors"))


def measure_cell(measure: Rms | Mapping[str, Any] | None) -> str:
    """Return an error in a table's cell: what rods measure on a line of its own.

    Examples
    --------
    >>> measure_cell({"translation": 4.17e-5, "rotation": 7.79e-5, "length": 5e-7}).splitlines()
    ['0.0417 mm and 0.0779 mrad', '0.000500 mm at the rods']
    """
    if not measure or part(measure, "length") is None:
        return measure_text(measure)
    others = {name: value for name, value in measure.items() if name != "length" and value is not None}
    rods = measure_text({"length": part(measure, "length")})
    return f"{measure_text(others)}\n{rods}" if others else rods


def part(measure: Rms | Mapping[str, Any] | None, key: str) -> float | None:
    """Take one entry of ``{translation, rotation, …}``, None where it is missing or null."""
    value = dict(measure.items()).get(key) if measure else None
    return None if value is None else float(value)


def in_sheets(members: Sequence[int], most: int, multiple: int = 1) -> list[Sequence[int]]:
    """Cut a row into sheets of nearly equal size, none above `most`, each but the last a multiple of `multiple`.

    Examples
    --------
    >>> in_sheets(range(10), 8), in_sheets(range(43), 20, multiple=5)
    ([range(0, 5), range(5, 10)], [range(0, 15), range(15, 30), range(30, 43)])
    """
    if not members:
        return []
    sheets = -(-len(members) // most)
    size = -(-len(members) // sheets)
    size = min(most, -(-size // multiple) * multiple)
    return [members[start : start + size] for start in range(0, len(members), size)]


def capital(text: str) -> str:
    """Return a text that begins with a capital letter."""
    return text[:1].upper() + text[1:]


def effect_at(effect: Placed) -> str:
    """Write an effect with its place, as far as it has one."""
    return f"{effect.effect} ({place(effect.where)})" if dict(effect.where.items()) else effect.effect
