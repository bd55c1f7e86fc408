"""The `rows` condition of a signal: ``test_nr < 100``, several joined by ``and``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated

from pydantic import BeforeValidator, WithJsonSchema

from stiffcal.campaign.toml.typed import WrongValueError

_NAME = r'"(?:[^"]|"")+"|`(?:[^`]|``)+`|[^\s<>=!"`]+'
_VALUE = r""""(?:[^"]|"")*"|'(?:[^']|'')*'|[^\s"']+"""
_CONDITION = re.compile(rf"\s*(?P<column>{_NAME})\s*(?P<operator><=|>=|==|!=|<|>)\s*(?P<value>{_VALUE})\s*")
_AND = re.compile(r"and(?=\s)")
_BARE = re.compile(r"[^\s<>=!\"`']+")


@dataclass(frozen=True)
class RowCondition:
    """One comparison of a column with a number or a text."""

    column: str
    """The column's name."""
    operator: str
    """One of < <= > >= == !=."""
    value: float | str
    """Number, or text (== and != only)."""


def parse_rows(text: str) -> tuple[RowCondition, ...]:
    """Read a condition on rows.

    Parameters
    ----------
    text : comparisons of a column with a number or a quoted text, joined by ``and``; a column's name with blanks or
        signs of comparison in it stands in double quotes or backticks. A quotation mark within quotes is written twice.

    Raises
    ------
    WrongValueError
        The text is not such a condition.

    Examples
    --------
    >>> parse_rows("test_nr < 100 and state == 'ok'")[1]
    RowCondition(column='state', operator='==', value='ok')
    """
    conditions, place = [], 0
    while True:
        match = _CONDITION.match(text, place)
        if match is None:
            raise WrongValueError(
                f"{text!r} is not a condition on rows",
                'write one like "test_nr < 100 and phase == 2"; a name with blanks in backticks, as "`X (mm)` != 0"',
            )
        value = _value(match["value"])
        if isinstance(value, str) and match["operator"] not in ("==", "!="):
            raise WrongValueError(f"{match['value']} is not a number", "compare text with == or != only")
        conditions.append(RowCondition(_unquoted(match["column"]), match["operator"], value))
        place = match.end()
        if place == len(text):
            return tuple(conditions)
        joined = _AND.match(text, place)
        # what follows without one is no condition
        place = joined.end() if joined is not None and text[place - 1].isspace() else len(text)


def condition_text(column: str, operator: str, value: float | str) -> str:
    """Return one comparison as `parse_rows` reads it.

    Examples
    --------
    >>> condition_text("test_nr", "<", 100), condition_text("X (mm)", "!=", 0)
    ('test_nr < 100', '`X (mm)` != 0')
    """
    is_bare = _BARE.fullmatch(column) is not None
    name = column if is_bare else "`" + column.replace("`", "``") + "`"
    written = "'" + value.replace("'", "''") + "'" if isinstance(value, str) else f"{value:.12g}"
    return f"{name} {operator} {written}"


def _unquoted(text: str) -> str:
    mark = text[0]
    return text[1:-1].replace(2 * mark, mark) if mark in "\"'`" else text


def _value(text: str) -> float | str:
    if text[0] in "\"'":
        return _unquoted(text)
    try:
        return float(text)
    except ValueError:
        raise WrongValueError(f"{text} is not a number", "write text in quotes, numbers with a decimal point") from None


MOST_ROWS = 1_000_000  # of one campaign, each held in memory: more than that is a run to be left out
_RANGE = re.compile(r"\s*(\d{1,12})\s*[-–…]\s*(\d{1,12})\s*")


def excluded_rows(value: object) -> tuple[int, ...]:
    """Return the rows that a list of numbers and ranges names.

    Examples
    --------
    >>> excluded_rows([3, "7-9"])
    (3, 7, 8, 9)
    """
    ranges = _ranges(value)
    check_excluded(sum(len(rows) for rows in ranges))
    return tuple(row for rows in ranges for row in rows)


def check_excluded(count: int) -> None:
    """Raise a `WrongValueError` where more rows are left out one by one than memory should hold."""
    if count > MOST_ROWS:
        raise WrongValueError(f"more than {MOST_ROWS} rows are left out", "leave out the run, or filter: rows = …")


def count_of_rows(value: object) -> int:
    """Return the number of rows that such a list names; 0 where it is none, which its own check reports."""
    try:
        return sum(len(rows) for rows in _ranges(value))
    except WrongValueError:
        return 0


def _ranges(value: object) -> list[range]:
    mend = 'count data rows from 1, ranges as text: rows = [3, "501-540"]'
    if not isinstance(value, list | tuple) or not value:
        raise WrongValueError(f"found {value!r}", mend)
    ranges = []
    for item in value:
        bounds = _RANGE.fullmatch(item) if isinstance(item, str) else None
        low, high = (int(bounds[1]), int(bounds[2])) if bounds else (item, item)
        if not isinstance(low, int) or not isinstance(high, int) or isinstance(item, bool) or not 1 <= low <= high:
            raise WrongValueError(f"found {item!r}", mend)
        ranges.append(range(low, high + 1))
    return ranges


ExcludedRows = Annotated[
    tuple[int, ...],
    BeforeValidator(excluded_rows),
    WithJsonSchema(
        {
            "type": "array",
            "minItems": 1,
            "items": {"anyOf": [{"type": "integer", "minimum": 1}, {"type": "string", "pattern": _RANGE.pattern}]},
        }
    ),
]
"""Row numbers and ranges of them."""
