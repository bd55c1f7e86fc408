r"""TOML that is printed or written: what stands there can be pasted into a file.

Everything that a name or a value could break is quoted here: names of columns hold blanks, brackets, quotes. Hidden
characters stand there as ``\u202e``, which a TOML parser turns back; halves of surrogate pairs, which no TOML can hold,
become U+FFFD.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from stiffcal.escapes import hidden

TomlValue: TypeAlias = "str | bool | int | float | Sequence[TomlValue] | Mapping[str, TomlValue]"
_BARE = re.compile(r"[A-Za-z0-9_-]+", re.ASCII)
_HALF = re.compile("[\ud800-\udfff]")


def escaped(text: str) -> str:
    r"""Return a text as a TOML string, quotation marks included.

    Examples
    --------
    >>> print(escaped('5" gauge'), escaped("\x7f\u202e"))
    "5\" gauge" "\u007f\u202e"
    """
    written = json.dumps(_HALF.sub("\ufffd", text), ensure_ascii=False)
    return hidden().sub(_code_point, written)


def _code_point(match: re.Match[str]) -> str:
    number = ord(match[0])
    return f"\\u{number:04x}" if number <= 0xFFFF else f"\\U{number:08x}"


def key(name: str) -> str:
    """Return a name as a key: bare where TOML allows it.

    Examples
    --------
    >>> print(key("ft_sensor"), key("X (mm)"), key("a.b"))
    ft_sensor "X (mm)" "a.b"
    """
    return name if _BARE.fullmatch(name) else escaped(name)


def value(of: TomlValue) -> str:
    """Return a value: texts, truth values, finite numbers, lists, and tables in one line.

    Examples
    --------
    >>> print(value({"column": "t [s]", "rate_hz": 50.0, "each": ["A1", True]}))
    { column = "t [s]", rate_hz = 50.0, each = ["A1", true] }
    """
    if isinstance(of, str):
        return escaped(of)
    if isinstance(of, bool | int | float):
        return json.dumps(of, allow_nan=False)
    if isinstance(of, Mapping):
        return "{ " + ", ".join(pair(name, entry) for name, entry in of.items()) + " }" if of else "{}"
    return "[" + ", ".join(map(value, of)) + "]"


def pair(name: str, of: TomlValue) -> str:
    """Return a key with its value.

    Examples
    --------
    >>> print(pair("files", {"ft": "raw/1.csv"}))
    files = { ft = "raw/1.csv" }
    """
    return f"{key(name)} = {value(of)}"
