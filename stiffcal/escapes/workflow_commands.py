r"""Commands that CI systems obey in what a program prints: GitHub's ``::error::``, Azure's ``##[section]``.

GitHub's runner takes a line that begins with ``::NAME`` for a command, blanks before it ignored, and ``##[NAME]``
anywhere in a line; Azure ``##vso[…]``, TeamCity ``##teamcity[…]``. See docs.github.com, "Workflow commands for GitHub
Actions", and ActionCommand.cs of github.com/actions/runner.
"""

from __future__ import annotations

import re
from functools import cache

from stiffcal.escapes import escape_invisible

# The runner's commands of one word, and all of more words, also those to come. A long line may be broken before any of
# its characters, and the closing `::` may come from another text, so that the opening counts anywhere.
_NAMES = "debug|echo|endgroup|error|group|notice|warning|[a-z]+-[a-z-]+"
_DATA = {"%": "%25", "\r": "%0D", "\n": "%0A"}
_PROPERTY = _DATA | {":": "%3A", ",": "%2C"}


@cache
def _command() -> re.Pattern[str]:
    return re.compile(rf":(?=:(?:{_NAMES})(?:::|\s|$))|#(?=#[a-z]*\[)", re.IGNORECASE)


def defused(text: str) -> str:
    r"""Return a text of one line in which no CI system finds a command, for whatever is printed.

    Examples
    --------
    >>> print(defused("::error::all is lost"), defused("a::b"), defused("##[group]"))
    \x3a:error::all is lost a::b \x23#[group]
    """
    if "::" not in text and "##" not in text:
        return text
    return _command().sub(lambda match: f"\\x{ord(match[0]):x}", text)


def escaped(text: str) -> str:
    r"""Return a text as the message of a command: ``::error::MESSAGE``.

    Examples
    --------
    >>> print(escaped("100 %\n::error::"))
    100 %25\n\x3a:error::
    """
    return "".join(_DATA.get(character, character) for character in defused(escape_invisible(text)))


def escaped_property(text: str) -> str:
    """Return a text as the value of a command's property: ``::error title=VALUE::``.

    Examples
    --------
    >>> escaped_property("a,b:c")
    'a%2Cb%3Ac'
    """
    return "".join(_PROPERTY.get(character, character) for character in escape_invisible(text))
