"""A comment in a program of a robot: KUKA KRL, ABB RAPID, Universal Robots script, Fanuc LS."""

from __future__ import annotations

import re

from stiffcal.escapes import escape_invisible

# Letters, digits and signs that end no comment and begin no instruction in any of the four languages.
_PLAIN = re.compile(r"[A-Za-z0-9 _.,:+/()<>-]")
# KUKA's editor hides lines from ";FOLD" to ";ENDFOLD".
_FOLD = re.compile("(?<=fo)(?=ld)", re.IGNORECASE)


def escaped(text: str) -> str:
    r"""Return a text on one line, of ASCII characters, that stays in a comment of these languages.

    Examples
    --------
    >>> print(escaped("cell 2; HALT"), escaped("x\nPTP"), escaped("Müller"))
    cell 2<U+3B> HALT x<U+5C>nPTP M<U+FC>ller
    >>> print(escaped(";ENDFOLD"))
    <U+3B>ENDFO LD
    """
    shown = "".join(
        character if _PLAIN.match(character) else f"<U+{ord(character):X}>" for character in escape_invisible(text)
    )
    return _FOLD.sub(" ", shown)
