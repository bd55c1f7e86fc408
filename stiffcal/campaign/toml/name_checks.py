"""Which characters a name that is used may hold, and how many: those that a reader of a name can see.

A control character, a separator of lines or an override of the direction of writing makes a name look like another one,
or like a line of its own. A name stands in every message about what it names, and a very long one would be all of it.
Names are refused for either, not repaired: the file may be an attack or be damaged.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from stiffcal.campaign.toml.explain import key_path
from stiffcal.errors import Fault, InputError
from stiffcal.escapes import refused
from stiffcal.fault_codes import FaultCode

# Keys whose texts are shown and never used: they may hold anything, and are escaped where they are shown.
_SHOWN_ONLY = frozenset({"why"})
# Keys of texts that are no names: a query may stand on several lines, a delimiter may be a tab.
_ON_LINES = frozenset({"file", "files"})
_CONDITIONS = frozenset({"rows"})
LONGEST_NAME = 1000
"""Characters: a topic of a bag with the field in it, or a path in HDF5, has some hundreds."""
_NAMED = frozenset({"id", "name"})
_EMPTY = ("the name is empty", "write a name of letters or digits")
_BLANKS = {"\n", "\r", "\t"}
CP1252 = 'it looks like Windows text read as latin-1: set csv = { encoding = "cp1252" } and write the letter itself'


def wrong_name(name: str) -> tuple[str, str] | None:
    r"""Return why a name is refused and what to do, or None where it is not.

    Examples
    --------
    >>> wrong_name("pose 1") is None, wrong_name("x" * 2000)
    (True, ('the name "xxxxxxxxxxxxxxxxxxxx…" has 2000 characters', 'write a name of at most 1000, in the logs too'))
    """
    return _too_long(name) or odd_character(name)


def _too_long(name: str) -> tuple[str, str] | None:
    if len(name) <= LONGEST_NAME:
        return None
    mend = f"write a name of at most {LONGEST_NAME}, in the logs too"
    return f'the name "{name[:20]}…" has {len(name)} characters', mend


def odd_character(text: str, allowed: frozenset[str] | set[str] = frozenset()) -> tuple[str, str] | None:
    r"""Return why a text is refused where a name is expected, and what to do, or None where it is not.

    Parameters
    ----------
    text : as it stands in a file.
    allowed : characters that pass.

    Examples
    --------
    >>> odd_character("Prüfstand 姿势") is None
    True
    >>> print(odd_character("pose\u202e1")[0])
    the name "pose\u202e1" contains U+202E, which changes the writing direction
    """
    character = next((match[0] for match in refused().finditer(text) if match[0] not in allowed), None)
    if character is None:
        return None
    code = ord(character)
    kind, mend = "a control character", "remove it, in the logs too"
    if 0x80 <= code < 0xA0:
        mend = CP1252
    elif code in (0x2028, 0x2029):
        kind = "a separator of lines"
    elif 0x202A <= code <= 0x2069:
        kind = "which changes the writing direction"
    elif code >= 0xD800:
        kind, mend = "which is not a character", "write the name in UTF-8"
    return f'the name "{text}" contains U+{code:04X}, {kind}', mend


def check_name(name: str, file: str, place: str) -> None:
    """Raise `InputError` where a name that a log or URDF holds is refused."""
    wrong = wrong_name(name)
    if wrong is not None:
        raise InputError.at(FaultCode.NAME_INVALID, file, place, *wrong)


def name_faults(document: dict[str, Any], file: str) -> Iterator[Fault]:
    """Yield a fault for every key and text of a TOML document that is refused as a name.

    Parameters
    ----------
    document : as read.
    file : how to call it in a fault.
    """
    waiting: list[tuple[tuple[int | str, ...], Any]] = [((), document)]
    while waiting:
        place, value = waiting.pop()
        if isinstance(value, dict):
            for key, item in value.items():
                wrong = wrong_name(key) or (_EMPTY if _is_blank(key, item) else None)
                if wrong is not None:
                    yield Fault(FaultCode.NAME_INVALID, file, key_path((*place, key), document), *wrong)
                elif key not in _SHOWN_ONLY:
                    waiting.append(((*place, key), item))
        elif isinstance(value, list):
            waiting += [((*place, index), item) for index, item in enumerate(value)]
        elif isinstance(value, str) and (len(value) > LONGEST_NAME or not value.isprintable()):
            may_be_long = (_ON_LINES | _CONDITIONS) & set(place[-2:])
            wrong = odd_character(value, _allowed(place)) or (None if may_be_long else _too_long(value))
            if wrong is not None:
                yield Fault(FaultCode.NAME_INVALID, file, key_path(place, document), *wrong)


def _is_blank(key: str, value: object) -> bool:
    """Return whether a key is an empty name, or gives something an empty name."""
    return not key.strip() or (key in _NAMED and isinstance(value, str) and not value.strip())


def _allowed(place: tuple[int | str, ...]) -> set[str]:
    if _ON_LINES & set(place[-2:]):
        return _BLANKS
    return {"\t"} if place[-1] == "delimiter" else set()
