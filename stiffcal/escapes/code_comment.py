"""A comment of C (``/* */``), of Structured Text (``(* *)``) or of XML (``<!-- -->``), which a name must not end."""

from __future__ import annotations

from stiffcal.escapes import escape_invisible

# Ends of comments of the three languages, beginnings (compilers warn of nested ones), and C's trigraphs.
_OPENERS_AND_ENDS = ("*/", "/*", "*)", "(*", "--", "//", "??")

_IN_ASCII = str.maketrans({"“": '"', "”": '"', "‘": "'", "’": "'", "–": "-", "·": " ", "±": "+/-", "°": " deg"})


def escaped(text: str) -> str:
    r"""Return a text on one line, of ASCII characters, that ends no comment of these languages and begins none.

    A blank or a line's end must follow it, as the mark that ends the comment may otherwise join its last character.

    Examples
    --------
    >>> print(escaped("*/ system(1); /*"))
    * / system(1); / *
    >>> print(escaped("Müller -->\n#define"))
    M<U+FC>ller - -><U+5C>n#define
    """
    text = escape_invisible(text).translate(_IN_ASCII)
    shown = "".join(
        character if character.isascii() and character != "\\" else f"<U+{ord(character):X}>" for character in text
    )
    changed = True
    while changed:
        before = shown
        for pair in _OPENERS_AND_ENDS:
            shown = shown.replace(pair, " ".join(pair))
        changed = shown != before
    return shown
