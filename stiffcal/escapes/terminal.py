"""A terminal, and the log of a CI system that takes what is printed there."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any

from stiffcal.escapes import escape_invisible
from stiffcal.escapes.workflow_commands import defused


def escaped(text: str) -> str:
    r"""Return a text as it may be printed: on one line, without any sequence that a terminal or a CI system obeys.

    Examples
    --------
    >>> print(escaped("\x1b]8;;http://x\x07click"), escaped("::add-mask::5"))
    \x1b]8;;http://x\x07click \x3a:add-mask::5
    """
    return defused(escape_invisible(text))


def escaped_lines(text: str) -> str:
    """Return a text of several lines, each of them as `escaped` has it."""
    return "\n".join(map(escaped, text.split("\n")))


def escaped_document(value: Any) -> Any:
    r"""Return a document or a result with all texts in it as `escaped` has them, keys included.

    Parameters
    ----------
    value : dicts, lists, dataclasses and values in any depth.

    Examples
    --------
    >>> escaped_document({"a\n": ["b\x07", 1.5]})
    {'a\\n': ['b\\x07', 1.5]}
    """
    if isinstance(value, str):
        return escaped(value)
    if isinstance(value, dict):
        return {escaped(key) if isinstance(key, str) else key: escaped_document(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(map(escaped_document, value))
    if value is None or isinstance(value, float | int):
        return value
    if is_dataclass(value) and not isinstance(value, type):
        changed = {}
        for name in _names(type(value)):
            before = getattr(value, name)
            after = escaped_document(before)
            if after is not before and after != before:
                changed[name] = after
        return replace(value, **changed) if changed else value
    return value


@cache
def _names(kind: type[Any]) -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind))
