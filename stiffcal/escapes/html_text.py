"""HTML: text between tags, values of attributes in quotation marks, data in a script."""

from __future__ import annotations

import html
import re
from typing import Any

from stiffcal.escapes import escape_invisible
from stiffcal.escapes.json_text import document_text


def escaped(text: str) -> str:
    """Return a text as it may stand between tags and between quotation marks of either kind.

    Examples
    --------
    >>> escaped('<a href="#">')
    '&lt;a href=&quot;#&quot;&gt;'
    """
    return html.escape(escape_invisible(text), quote=True)


def script_data(document: Any) -> str:
    r"""Return a document as it may stand in a script or in ``<script type="application/json">``.

    No character of it ends the script or begins a comment.

    Examples
    --------
    >>> print(script_data({"name": "</script><!--"}))
    {"name": "\u003c/script\u003e\u003c!--"}
    """
    return re.sub(r"[<>&]", lambda match: f"\\u{ord(match[0]):04x}", document_text(document, indent=None))
