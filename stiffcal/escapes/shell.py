"""A word of a line that is printed to be copied into a shell (bash, zsh, ksh)."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

from stiffcal.escapes.terminal import escaped as printable


def escaped(text: str) -> str:
    r"""Return a text as one word, without a character that a terminal obeys or that is no text.

    What cannot be printed is written in the form ``$'\033'``, byte by byte, which bash, zsh and ksh turn back.

    Examples
    --------
    >>> print(escaped("a b"), escaped("$(x)"), escaped("two\nlines"))
    'a b' '$(x)' $'two\x0alines'
    """
    if printable(text) == text:
        return shlex.quote(text)
    written = []
    for character in text:
        if character in "\\'":
            written.append(f"\\{character}")
        elif character in ":#" or printable(character) != character:
            written += [f"\\x{byte:02x}" for byte in _bytes_of(character)]
        else:
            written.append(character)
    return "$'" + "".join(written) + "'"


def escaped_path(text: str) -> str:
    """Return a path as one word that no command takes for an option.

    Examples
    --------
    >>> escaped_path("-rf"), escaped_path("cells/-rf")
    ('./-rf', 'cells/-rf')
    """
    return escaped(f".{os.sep}{text}" if text.startswith("-") else text)


NAMES_ITS_FOLDER = frozenset({"add", "batch", "compare", "init", "remove", "simulate", "trend"})
"""Commands that do not take the current folder where none is given."""


def command_line(command: str, folder: Path, *words: str, store: str | None = None) -> str:
    """Return a `stiffcal` line to copy.

    Examples
    --------
    >>> command_line("validate", Path("my campaign"), "--quick")
    "stiffcal validate 'my campaign' --quick"
    >>> command_line("validate", Path("."))
    'stiffcal validate'
    >>> command_line("add", Path("."), "backlash", "--joints", "4")
    'stiffcal add . backlash --joints 4'
    """
    place = [] if folder == Path() and command not in NAMES_ITS_FOLDER else [escaped_path(str(folder))]
    elsewhere = ["--store", escaped(store)] if store else []
    return " ".join(["stiffcal", command, *place, *map(escaped, words), *elsewhere])


def _bytes_of(character: str) -> bytes:
    try:
        return character.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:  # half a pair that stands for no byte: no system has such a name
        return character.encode("utf-8", "surrogatepass")
