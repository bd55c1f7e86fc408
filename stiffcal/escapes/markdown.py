"""Markdown as GitHub and GitLab show it, for one cell of a table or the text of one item of a list."""

from __future__ import annotations

import re

from stiffcal.escapes import escape_invisible

_SPECIAL = re.compile(r"[\\`*_{}\[\]<>&|~$]")
# What becomes a link without any mark of Markdown: @name, #12, GH-12, !12 (GitLab), :smile:, addresses.
_LINKING = re.compile(r"[@#!](?=\w)|GH-(?=\d)|:(?=//)|www(?=\.)|(?<!\d):(?=[\w+-]+:)", re.IGNORECASE)
# What begins a heading, a list, a line, a quotation or a block of code where it stands first.
_BEGINNING = re.compile(r"[-+=# ]|\d{1,9}(?=[.)])")
_BREAK = "&#8203;"  # of no width: it is not visible, and what it splits is no link


def escaped(text: str) -> str:
    r"""Return a text on one line that is no Markdown, no HTML, no formula and no link.

    Examples
    --------
    >>> print(escaped("<b>|x_1|"), escaped("@all, see #12"), escaped("- 5 %"))
    &lt;b&gt;&#124;x\_1&#124; @&#8203;all, see #&#8203;12 &#45; 5 %
    """
    text = escape_invisible(text)
    beginning = _BEGINNING.match(text)
    start = ""
    if beginning is not None:
        start, text = beginning[0], text[beginning.end() :]
        if not start.isdigit():
            start = f"&#{ord(start)};" + (_BREAK if start == "#" and text[:1].isalnum() else "")
        else:
            start, text = f"{start}&#{ord(text[0])};", text[1:]
    parts, done = [start], 0
    for match in _LINKING.finditer(text):
        parts += [_SPECIAL.sub(_inert, text[done : match.end()]), _BREAK]
        done = match.end()
    return "".join(parts) + _SPECIAL.sub(_inert, text[done:])


def _inert(match: re.Match[str]) -> str:
    # A backslash does not help in all of these: GitHub looks for $…$ and for cells before it reads it.
    return f"\\{match[0]}" if match[0] in "`*_{}[]~" else _ENTITIES[match[0]]


_ENTITIES = {"<": "&lt;", ">": "&gt;", "&": "&amp;", "|": "&#124;", "$": "&#36;", "\\": "&#92;"}
