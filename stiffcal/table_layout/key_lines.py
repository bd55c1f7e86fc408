"""Lines above a table's header that state something about it: rate, unit of lengths, names of markers.

Programs that record motion or forces write such lines as a key and its values (Qualisys: ``FREQUENCY⇥100``), as pairs
in one line (Motive: ``Export Frame Rate,100,…,Length Units,Millimeters``) or as text (ATI: ``Sample Rate: 1000``).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from stiffcal.campaign.columns.column_headers import is_unit_of

# Repetitions are bounded: these are searched in a log's first lines, which anybody may have written.
_NUMBER = r"[^0-9\n]{0,30}([0-9]{1,30}(?:[.,][0-9]{1,30})?)"
_RATES = tuple(
    re.compile(words + _NUMBER, re.IGNORECASE)
    for words in (
        r"export (?:frame ?)?rate",
        r"(?:\bsampl\w{0,12}[ _-]?(?:rate|frequency)|\bdata ?rate|\bframe ?rate|abtastrate|\bfrequen[cz]\w{0,12})",
    )
)
_PERIOD = re.compile(
    r"(?:sample ?time|abtastzeit|cycle ?time|sampl\w{0,12} ?(?:period|interval))\s{0,9}\[?\s{0,9}(ms|us|s)\]?"
    + _NUMBER,
    re.IGNORECASE,
)
_ALONE = re.compile(r"[0-9]{1,9}(?:\.[0-9]{1,9})?")
_STEP = re.compile(r"^delta_x\s+" + _NUMBER, re.IGNORECASE)
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
_MARKER_KEYS = ("marker_names", "markernames", "markers", "marker names")
_OF_BODY = ("X", "Y", "Z", "Roll", "Pitch", "Yaw", "Residual", *(f"Rot[{k}]" for k in range(9)))
_LENGTH_KEYS = ("length units", "length unit", "units", "unit", "einheit")


def rate_of(rows: Sequence[Sequence[str]]) -> float | None:
    """Return the number of rows per second that lines above a header state; None where they state none.

    Examples
    --------
    >>> rate_of([["NO_OF_FRAMES", "471"], ["FREQUENCY", "2.5"]]), rate_of([["SampleTime[ms]", "20"]])
    (2.5, 50.0)
    """
    lines = [" ".join(row) for row in rows]
    for pattern in _RATES:
        for line in lines:
            if (found := pattern.search(line)) is not None and (hertz := _positive(found[1])):
                return hertz
    for title, line in pairwise(lines):  # Vicon: the number alone, below the title of its part
        if title[:1].isalpha() and _ALONE.fullmatch(line.strip()) and (hertz := _positive(line)):
            return hertz
    for line in lines:
        if (found := _PERIOD.search(line)) is not None and (step := _positive(found[2])):
            return 1.0 / (step * _SECONDS[found[1].lower()])
        if (found := _STEP.search(line)) is not None and (step := _positive(found[1])):
            return 1.0 / step
    return None


def length_unit_of(rows: Sequence[Sequence[str]]) -> str | None:
    """Return the unit of lengths that lines above a header state, as written; None where they state none.

    Examples
    --------
    >>> length_unit_of([["Format Version", "1.25", "Length Units", "Millimeters"]])
    'Millimeters'
    >>> length_unit_of([["DataRate", "NumMarkers", "Units"], ["50.00", "2", "mm"]])
    'mm'
    """
    for key, value in _pairs(rows):
        if key in _LENGTH_KEYS and (unit := next((u for u in _listed(value) if is_unit_of(u, "length")), None)):
            return unit
    return None


def _listed(value: str) -> list[str]:
    """Return the units that a value lists, as "mm, deg"."""
    return [part.strip() for part in value.split(",")]


def marker_names(rows: Sequence[Sequence[str]], width: int) -> tuple[str, ...]:
    """Return three names for each marker that a line above the numbers lists; empty where none lists them.

    Parameters
    ----------
    width : columns of the table: three for each marker, and up to two before them (frame, time).

    Examples
    --------
    >>> marker_names([["MARKER_NAMES", "probe", "base"]], 6)
    ('probe X', 'probe Y', 'probe Z', 'base X', 'base Y', 'base Z')
    """
    for row in rows:
        names = [cell for cell in row[1:] if cell]
        before = width - 3 * len(names)
        if row and row[0].lower() in _MARKER_KEYS and names and 0 <= before <= 2:
            return (*("Frame", "Time")[:before], *(f"{name} {axis}" for name in names for axis in "XYZ"))
    return ()


def body_names(rows: Sequence[Sequence[str]], width: int) -> tuple[str, ...]:
    """Return the names of the columns of rigid bodies that a line lists (Qualisys, 6D); empty where none lists them.

    A line below names the components of the first body alone, or of each, without the body.

    Parameters
    ----------
    width : columns of the table: sixteen for each body, and up to two before them (frame, time).

    Examples
    --------
    >>> names = body_names([["DATA_INCLUDED", "6D"], ["BODY_NAMES", "probe", "base"]], 33)
    >>> len(names), names[:5], names[-1]
    (33, ('Frame', 'probe X', 'probe Y', 'probe Z', 'probe Roll'), 'base Rot[8]')
    """
    for row in rows:
        bodies = [cell for cell in row[1:] if cell]
        before = width - len(_OF_BODY) * len(bodies)
        if row and row[0].lower() == "body_names" and bodies and 0 <= before <= 2:
            return (*("Frame", "Time")[:before], *(f"{body} {part}" for body in bodies for part in _OF_BODY))
    return ()


def _pairs(rows: Sequence[Sequence[str]]) -> Iterator[tuple[str, str]]:
    for row in rows:
        for key, value in pairwise(row):
            yield key.strip(" :").lower(), value
        for cell in row:  # in one cell, perhaps behind the sign of a comment
            key, colon, value = cell.partition(":")
            if colon:
                yield key.strip(" #%;/!").lower(), value.strip()
    for keys, values in pairwise(rows):  # .trc: keys in a line, their values below them
        if len(keys) == len(values):
            for key, value in zip(keys, values, strict=True):
                yield key.strip(" :").lower(), value


def _positive(text: str) -> float:
    return float(text.replace(",", "."))
