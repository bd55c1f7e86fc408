"""Cells of a table as they are written: numbers with either decimal mark, groups of three digits, times, gaps."""

from __future__ import annotations

import re
from collections.abc import Iterable

from stiffcal.measurements.timestamps import in_usual_form

GAP_WORDS = frozenset(
    (
        *("", "nan", "-nan", "na", "n/a", "#n/a", "#nv", "null", "none", "missing", "lost", "-", "--", "---"),
        *("-3.697314e28", "-3.697314e+28", "-3.697314e+028", "-3.69731e+28", "-3.69731e+028"),  # NDI: no reading
        *("1.#qnan", "1.#ind", "-1.#ind", "nan(ind)", "-nan(ind)", "nan.0"),  # a C library of Windows
    )
)
"""What stands for a missing reading, in small letters."""

GROUP_MARKS = "., '\u00a0\u202f\u2019"
"""What separates groups of three digits: a point, a comma, a blank (also one that does not break), an apostrophe."""

# the exponent of a double number in Fortran, 1.5D+03, follows a decimal mark: 3D2 is a name
_PLAIN = re.compile(r"[+\-\u2212]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|(?:\d+\.\d*|\.\d+)[dD][+-]?\d+)")
_COMMA = re.compile(r"[+\-\u2212]?\d*,\d+(?:[eEdD][+-]?\d+)?")
_POINT = re.compile(r"[+\-\u2212]?\d*\.\d+(?:[eEdD][+-]?\d+)?")
WRITTEN_OTHERWISE = re.compile(rb"\d[.,]\d*[dD][+-]?\d|\xe2\x88\x92[\d.,]")
"""Numbers in the bytes of a text that only `number` reads: exponents of Fortran, the minus sign of Sweden (U+2212)."""
_AS_USUAL = str.maketrans("dD\u2212", "eE-")
_GROUPED = re.compile(
    rf"[+\-\u2212]?\d{{1,3}}(?P<groups>(?:([{GROUP_MARKS}])\d{{3}})(?:\2\d{{3}})*)(?:(?P<decimal>[.,])\d+)?"
)
_TIME = re.compile(
    r"'?(?:\d{1,4}([-./ ])(?:\d{1,2}|[^\W\d_]{3,9}\.?)\1\d{1,4}(?:[ T,]+\d{1,2}:\d{2}(?::\d{2}(?:[.,:]\d+)?)?)?"
    r"|\d{1,2}:\d{2}:\d{2}(?:[.,:]\d+)?|\d{1,2}:\d{2}[.,]\d+)"
    r"(?: ?[AaPp][Mm])?(?: ?(?:Z|UTC|GMT|[+-]\d{2}:?\d{2}))?"
)
_LONGEST_GAP = max(map(len, GAP_WORDS)) + 1
_SHORTEST_DATE = 9  # 2026年1月2日
_LONGEST = 60  # characters of a number or a time


def marks_of(cells: Iterable[str]) -> tuple[str, str]:
    """Return the decimal mark of numbers and the mark between groups of three digits, "" where there is none.

    Parameters
    ----------
    cells : of a table; words among them do no harm.

    Examples
    --------
    >>> marks_of(["1.5", "name"]), marks_of(["1,5", "2"]), marks_of(["1.234,5"]), marks_of(["1,234", "0.5"])
    (('.', ''), (',', ''), (',', '.'), ('.', ','))
    """
    commas = points = grouped_commas = grouped_points = 0
    certain: tuple[str, str] | None = None
    apart = ""
    for cell in cells:
        if len(cell) > _LONGEST or cell.isdigit():
            continue
        if _POINT.fullmatch(cell):
            points += 1
            grouped_points += _GROUPED.fullmatch(cell) is not None
        elif _COMMA.fullmatch(cell):
            commas += 1
            grouped_commas += _GROUPED.fullmatch(cell) is not None
        elif (match := _GROUPED.fullmatch(cell)) is not None:
            mark = match[2]
            if mark in ".,":  # two groups, or a decimal mark behind the groups: only one reading is left
                certain = certain or (match["decimal"] or ("," if mark == "." else "."), mark)
            else:
                apart = mark
    if certain is not None and certain[0] != certain[1]:
        return certain
    if commas and points:  # of the two the one that only separates groups of three digits is no decimal mark
        if points == grouped_points and commas > grouped_commas:
            return ",", "."
        if commas == grouped_commas and points > grouped_points:
            return ".", ","
    return ("," if commas > points else "."), apart


def number(cell: str, decimal: str, thousands: str) -> float | None:
    """Return a cell as a number; None where it is none.

    Examples
    --------
    >>> number("1.234,5", ",", "."), number("1,5", ".", ""), number("+3e2", ".", ""), number("1.5D+03", ".", "")
    (1234.5, None, 300.0, 1500.0)
    """
    plain = _without_marks(cell, decimal, thousands)
    return float(plain.translate(_AS_USUAL)) if _PLAIN.fullmatch(plain) and not is_gap(cell) else None


def _without_marks(cell: str, decimal: str, thousands: str) -> str:
    """Return a number's text with a decimal point and no groups; "" where the marks are other ones."""
    if thousands and thousands in cell:
        if _GROUPED.fullmatch(cell) is None:
            return ""
        cell = cell.replace(thousands, "")
    if decimal != ".":
        return "" if "." in cell else cell.replace(decimal, ".")
    return cell


def is_gap(cell: str) -> bool:
    """Return whether a cell stands for a missing reading."""
    return len(cell) < _LONGEST_GAP and cell.lower() in GAP_WORDS


def is_time(cell: str) -> bool:
    """Return whether a cell is a date, a time of day, or both.

    Examples
    --------
    >>> [is_time(cell) for cell in ("20.11.2026 10:15:30,000", "0:15:30.5", "Nov 20, 2026 1:15 PM", "1.5", "A1")]
    [True, True, True, False, False]
    """
    if len(cell) > _LONGEST:
        return False
    if cell.removeprefix("'")[:1].isdigit() and _TIME.fullmatch(cell) is not None:
        return True
    # written in another way it is longer than any number of rows or names of columns
    return len(cell) >= _SHORTEST_DATE and not cell.isdigit() and in_usual_form(cell) != cell


def is_reading(cell: str, decimal: str, thousands: str) -> bool:
    """Return whether a cell is a number or a time."""
    return _PLAIN.fullmatch(
        cell if decimal == "." and not thousands else _without_marks(cell, decimal, thousands)
    ) is not None or is_time(cell)
