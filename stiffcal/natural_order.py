"""Names sorted as people count."""

from __future__ import annotations

import re
from typing import TypeAlias

_DIGITS = re.compile(r"([0-9]+)")
NameKey: TypeAlias = tuple[tuple[int, int, str], ...]
"""By which names of runs are sorted and compared."""


def natural_key(name: str) -> NameKey:
    """Return the key by which names are sorted as people count: numbers in them by their value.

    Two names that differ in leading zeros alone have the same key.

    Examples
    --------
    >>> sorted(["pose10", "pose9", "pose2b"], key=natural_key)
    ['pose2b', 'pose9', 'pose10']
    >>> natural_key("pose07") == natural_key("pose7")
    True
    """
    # a number: its count of digits, then these; thousands of digits are no int in Python
    parts: list[tuple[int, int, str]] = []
    for k, text in enumerate(_DIGITS.split(name)):
        if k % 2:
            digits = text.lstrip("0")
            parts.append((0, len(digits), digits))
        elif text:
            parts.append((1, 0, text))
    return tuple(parts)
