r"""JSON, which is printed on terminals, read by programs and stored.

All that is hidden stands there as ``\u001b``, which a JSON parser turns back into the character: nothing is lost. The
names of folders that are no UTF-8 are in Python texts with lone surrogates; JSON writes those as ``\udcff`` too.
"""

from __future__ import annotations

import json
import re
from typing import Any

from stiffcal.escapes import hidden

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
    document : dicts, lists, texts, finite numbers, true, false and None.
    indent : blanks of each level; None: all on one line.

    Raises
    ------
    ValueError : a number is not finite.
    """
    return _escape_hidden(json.dumps(document, indent=indent, ensure_ascii=False, allow_nan=False))


def _escape_hidden(text: str) -> str:
    """Write hidden characters as JSON does; between the texts of a document there are none but line feeds."""
    if not text.isascii() or "\x7f" in text:
        # sought among the characters that occur: a document has many lines, and few characters
        found = hidden().findall("".join(set(text) - {"\n"}))
        written_out = {ord(character): json.dumps(character)[1:-1] for character in found}
        text = text.translate(written_out) if found else text
    return _COMMAND.sub(r"\\u0023", text) if "##" in text else text
