"""XML: JUnit's report, URDF."""

from __future__ import annotations

from xml.sax.saxutils import escape

from stiffcal.escapes import escape_invisible


def characters(text: str) -> str:
    r"""Return a text of characters that XML 1.0 has, for a library that writes ``<`` and ``&`` as XML asks for.

    Control characters stand in no XML, not even as ``&#27;``; they are written out.

    Examples
    --------
    >>> print(characters("a\x1b<b"))
    a\x1b<b
    """
    return escape_invisible(text)


def escaped(text: str) -> str:
    """Return a text as it may stand between tags and between quotation marks of either kind.

    Examples
    --------
    >>> escaped('<a b="c">')
    '&lt;a b=&quot;c&quot;&gt;'
    """
    return escape(characters(text), {'"': "&quot;", "'": "&apos;"})
