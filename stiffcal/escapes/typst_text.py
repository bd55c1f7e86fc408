"""A page set by typst: all texts reach it as data (JSON), never as markup, so that ``#``, ``$`` and ``*`` are text."""

from __future__ import annotations

from typing import Any

from stiffcal.escapes import escape_invisible


def escaped(text: str) -> str:
    r"""Return a text as it may be printed on a page; lines stay lines.

    Examples
    --------
    >>> print(escaped("#eval(1) $x$ \x1b"))
    #eval(1) $x$ \x1b
    """
    return "\n".join(map(escape_invisible, text.split("\n")))


def escaped_data(value: Any) -> Any:
    """Return the data of a page with all texts in it as `escaped` has them."""
    if isinstance(value, str):
        return escaped(value)
    if isinstance(value, dict):
        return {key: escaped_data(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [escaped_data(item) for item in value]
    return value
