r"""JSON, which is printed on terminals, read by programs and stored.

All that is hidden stands there as ``\u001b``, which a JSON parser turns back into the character: nothing is lost. The
names of folders that are no UTF-8 are in Python texts with lone surrogates; JSON writes those as ``\udcff`` too.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable
from functools import cache
from json.encoder import encode_basestring
from typing import Any

from stiffcal.escapes import hidden

_CONTAINERS = (dict, list, tuple)
_KINDS = frozenset(_CONTAINERS)
_PLAIN = bytes((*b"\n", *range(0x20, 0x7F)))  # never hidden, and most of a document
_COMMAND = re.compile(r"#(?=#[A-Za-z]*\[)")  # no line of JSON begins with a text, so that `::` does nothing


def escaped(text: str) -> str:
    r"""Return a text as a JSON text, quotation marks included.

    Examples
    --------
    >>> print(escaped("Müller \x9b \u202e"))
    "Müller \u009b \u202e"
    """
    return _escape_hidden(json.dumps(text, ensure_ascii=False))


def document_text(document: Any, *, indent: int | None = 2) -> str:
    """Return a document as JSON.

    Parameters
    ----------
    document : dicts with texts as keys, lists, texts, finite numbers, true, false and None.
    indent : blanks of each level; None: all on one line.

    Raises
    ------
    ValueError : a number is not finite.
    """
    text = _encoder(", ").encode(document) if indent is None else _indented(document, " " * indent, "\n")
    return _escape_hidden(text)


@cache
def _encoder(between: str) -> json.JSONEncoder:
    """Return the encoder whose items stand apart by a text; without an indent it is the one written in C."""
    return json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(between, ": "))


def _indented(value: Any, step: str, outer: str) -> str:
    """Return a value as `json.dumps` indents it, which holds a text of each token: of a thousand runs 20 MB.

    Parameters
    ----------
    step : blanks of a level. outer : line feed and blanks before the value's last bracket.
    """
    if not isinstance(value, _CONTAINERS) or not value:
        return _single(value)
    inner = outer + step
    between = f",{inner}"
    items = value.values() if isinstance(value, dict) else value
    if not _holds_containers(items):
        flat = _encoder(between).encode(value)
        return f"{flat[0]}{inner}{flat[1:-1]}{outer}{flat[-1]}"
    if not isinstance(value, dict) and all(_is_flat(item) for item in value):
        deeper = inner + step
        # no text holds a line feed as it is: one that stands between two braces parts two items
        texts = _encoder(f",{deeper}").encode(value)[2:-2].replace(f"}},{deeper}{{", f"{inner}}},{inner}{{{deeper}")
        return f"[{inner}{{{deeper}{texts}{inner}}}{outer}]"
    if not isinstance(value, dict):
        return f"[{inner}{between.join(_indented(item, step, inner) for item in value)}{outer}]"
    members = (f"{_single(key)}: {_indented(item, step, inner)}" for key, item in value.items())
    return f"{{{inner}{between.join(members)}{outer}}}"


def _single(value: Any) -> str:
    """Return what is no container, or an empty one; numbers and names without an encoder made for each."""
    kind = type(value)
    if kind is int or (kind is float and math.isfinite(value)):
        return repr(value)
    return encode_basestring(value) if kind is str else _encoder(", ").encode(value)


def _is_flat(value: Any) -> bool:
    """Return whether a value is an object that holds something, and no containers but empty ones."""
    return isinstance(value, dict) and bool(value) and not _holds_containers(value.values())


def _holds_containers(values: Iterable[Any]) -> bool:
    """Return whether any value is a container that holds something: an empty one is written as a number is."""
    return not _KINDS.isdisjoint(map(type, values)) and any(value for value in values if type(value) in _KINDS)


def _escape_hidden(text: str) -> str:
    """Write hidden characters as JSON does; between the texts of a document there are none but line feeds."""
    if not text.isascii() or "\x7f" in text:
        # sought among the characters that occur: a document has many lines, and few characters
        rest = text.encode("utf-8", "surrogatepass").translate(None, _PLAIN).decode("utf-8", "surrogatepass")
        found = hidden().findall("".join(set(rest)))
        written_out = {ord(character): json.dumps(character)[1:-1] for character in found}
        text = text.translate(written_out) if found else text
    return _COMMAND.sub(r"\\u0023", text) if "##" in text else text
