r"""One escape for each place that text goes to, one file each: a further place is one file more.

Names and words come from a campaign's files, which anybody may have written. Where they are printed, written or drawn
they must stay text: start no command of a terminal, no formula of a spreadsheet, no tag, no mention, no line of their
own. Every module of this folder has a function `escaped`, which returns a text as it may stand there; `sinks` finds
them all, and a test walks one set of hostile names through each.

What no reader of a name can see (control characters, separators of lines, changes of the direction of writing, bytes
that are no text) is written out everywhere, as ``\x1b`` or ``\u202e``: removing it would make two names look equal.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from functools import cache

_CONTROL = "\x00-\x1f\x7f-\x9f"
_LINES = "\u2028\u2029"
# Embeddings, overrides and isolates of the Unicode bidirectional algorithm (UAX 9): they reorder what follows them.
_DIRECTIONS = "\u202a-\u202e\u2066-\u2069"
# Halves of surrogate pairs: how Python holds the bytes of a file's name that is not UTF-8; no file of text takes them.
_NO_TEXT = "\ud800-\udfff"
_NONCHARACTERS = "\ufdd0-\ufdef\ufffe\uffff" + "".join(
    f"{chr(k)}{chr(k + 1)}" for k in range(0x1FFFE, 0x110000, 1 << 16)
)
# They change nothing but are not visible: marks of direction (Arabic and Hebrew texts hold them), breaks and fillers
# of no width. The joiners U+200C and U+200D stay: Persian words and emoji are made with them.
_OF_NO_WIDTH = "\u061c\u200e\u200f\xad\u180e\u200b\u2060-\u2065\u206a-\u206f\ufeff\ufff9-\ufffb"

# Expressions are compiled when they are first needed: every command imports this module, and few need them.


@cache
def refused() -> re.Pattern[str]:
    """Return the pattern of characters that no name that is used may hold."""
    return re.compile(f"[{_CONTROL}{_LINES}{_DIRECTIONS}{_NO_TEXT}{_NONCHARACTERS}]")


@cache
def hidden() -> re.Pattern[str]:
    """Return the pattern of characters that are written out wherever they are shown."""
    return re.compile(f"[{_CONTROL}{_LINES}{_DIRECTIONS}{_NO_TEXT}{_NONCHARACTERS}{_OF_NO_WIDTH}]")


def escape_invisible(text: str) -> str:
    r"""Return a text on one line in which every invisible character is written out.

    Examples
    --------
    >>> print(escape_invisible("two\nlines, \x1b[31mred, Müller \U0001f600"))
    two\nlines, \x1b[31mred, Müller 😀
    """
    return text if text.isascii() and text.isprintable() else hidden().sub(_written_out, text)


def _written_out(match: re.Match[str]) -> str:
    return match[0].encode("unicode_escape").decode("ascii")


def sinks() -> dict[str, Callable[[str], str]]:
    """Return the escape of each place by the name of its module.

    Examples
    --------
    >>> sinks()["html_text"]("<b>")
    '&lt;b&gt;'
    """
    import pkgutil

    names = sorted(entry.name for entry in pkgutil.iter_modules(__path__))
    return {name: importlib.import_module(f"{__name__}.{name}").escaped for name in names}
