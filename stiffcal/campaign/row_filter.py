"""The `rows` condition of a signal: ``test_nr < 100``, several joined by ``and``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from stiffcal.campaign.typed import WrongValueError

_CONDITION = re.compile(
    r"""^\s*(?P<column>"[^"]+"|`[^`]+`|[^\s<>=!"`]+)\s*(?P<operator><=|>=|==|!=|<|>)\s*(?P<value>"[^"]*"|'[^']*'|\S+)\s*$"""
)


@dataclass(frozen=True)
class RowCondition:
    """One comparison of a column with a number or a text.

    Attributes
    ----------
    column : the column's name. operator : one of < <= > >= == !=. value : number, or text (== and != only).
    """

    column: str
    operator: str
    value: float | str


def parse_rows(text: str) -> tuple[RowCondition, ...]:
    """Read a condition on rows.

    Parameters
    ----------
    text : comparisons of a column with a number or a quoted text, joined by ``and``; a column's name with blanks in it
        stands in double quotes or backticks.

    Raises
    ------
    WrongValueError
        The text is not such a condition.

    Examples
    --------
    >>> parse_rows("test_nr < 100 and state == 'ok'")[1]
    RowCondition(column='state', operator='==', value='ok')
    """
    conditions = []
    for part in re.split(r"\s+and\s+", text):
        match = _CONDITION.match(part)
        if match is None:
            raise WrongValueError(
                f'"{text}" is not a condition on rows', 'write one like "test_nr < 100 and phase == 2"'
            )
        value = _value(match["value"])
        if isinstance(value, str) and match["operator"] not in ("==", "!="):
            raise WrongValueError(f"{match['value']} is not a number", "compare texts with == or != only")
        conditions.append(RowCondition(match["column"].strip('"`'), match["operator"], value))
    return tuple(conditions)


def _value(text: str) -> float | str:
    if text[0] in "\"'":
        return text[1:-1]
    try:
        return float(text)
    except ValueError:
        raise WrongValueError(
            f"{text} is not a number", "write texts in quotes, numbers with a decimal point"
        ) from None
