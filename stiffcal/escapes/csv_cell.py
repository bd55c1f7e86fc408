"""A cell of a CSV file that a spreadsheet opens: text stays text, and starts no formula.

Spreadsheets take a cell that begins with = + - @ for a formula, after a tab or a carriage return too (OWASP, "CSV
Injection"). Such a text gets a single quotation mark before it, which spreadsheets take for "this is text"; our own
readers take it off again. Numbers stay numbers.
"""

from __future__ import annotations

import re

_FORMULA = re.compile("'*[=+\\-@\t\r\n\uff1d\uff0b\uff0d\uff20]")
_MARKED = re.compile("'" + _FORMULA.pattern)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def escaped(text: str) -> str:
    """Return a text as the content of a cell; the CSV library adds quotation marks where delimiters ask for them.

    Examples
    --------
    >>> escaped("=HYPERLINK(1)"), escaped("-1.5"), escaped("pose 1"), escaped("'=1")
    ("'=HYPERLINK(1)", '-1.5', 'pose 1', "''=1")
    """
    return f"'{text}" if _FORMULA.match(text) and not _NUMBER.fullmatch(text) else text


def original(cell: str) -> str:
    """Return the text that `escaped` made a cell of.

    Examples
    --------
    >>> [original(escaped(text)) for text in ("=1", "'=1", "'quoted'", "-1.5")]
    ['=1', "'=1", "'quoted'", '-1.5']
    """
    return cell[1:] if cell[:1] == "'" and _MARKED.match(cell) else cell
