"""Reading a TOML file: syntax faults with line and column, then the types, every fault at once.

All TOML is parsed here, and nowhere else: both parsers, Python's own and the one that keeps comments, need time and
memory that grow with the square of the parts of a dotted key and more, so none of them is given a text before its keys
have been counted.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable
from itertools import groupby, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ValidationError

from stiffcal.campaign.toml.explain import faults_of, key_path
from stiffcal.campaign.toml.name_checks import name_faults
from stiffcal.campaign.toml.reach import read_given
from stiffcal.errors import InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.limits import ENTRIES, RUNS, TOML

if TYPE_CHECKING:
    from tomlkit import TOMLDocument

Model = TypeVar("Model", bound=BaseModel)

LARGEST = 1e30  # in SI: what is larger overflows somewhere in the physics, and is a slip
SMALLEST = 1e-100  # its square is still a number; below it only slips are written
MOST_ODD_NAMES = 20  # that are shown, each on its line
MOST_NESTED = 20  # tables in tables: twice what any of our files needs
WHOLE_NUMBERS = range(-(2**63), 2**63)  # TOML 1.0: what a reader has to hold
_MANY = frozenset({"runs", "exclude", "rows", "campaigns", "parameters"})
"""Keys of lists and tables that grow with what was measured; all others are a robot's or an instrument's."""
_SYNTAX_MEND = "correct that line: text in quotes, decimal points, each key and table once"
_DEEP = "tables or lists are nested too deeply"
_OPENING = re.compile(r"\"\"\"|'''|[\"'#]")
_ENDS = {
    '"""': re.compile(r'\\.|"{3,5}', re.DOTALL),
    "'''": re.compile(r"'{3,5}"),
    '"': re.compile(r'\\[^\n]|["\n]'),
    "'": re.compile(r"['\n]"),
    "#": re.compile(r"\n"),
}
"""What may end a string or comment with this opening, and in which strings a pair with a backslash ends nothing."""
_DEEP_KEY = re.compile(rf"(?:\.[^.=,\[\]{{}}\n]*+){{{MOST_NESTED}}}")
"""More dots between two signs of TOML's grammar than a key has whose tables may be nested so deeply."""
_DOTTED_KEY = re.compile(r"\.[^.=,\[\]{}\n]*+=")

_PLACE = re.compile(r"\s*\(at (?P<place>line \d+, column \d+|end of document)\)$")


def read_toml(path: Path, file: str, *, from_user: bool = False) -> dict[str, Any]:
    """Read a TOML document.

    Parameters
    ----------
    path : where it lies.
    file : how to call it in a fault.
    from_user : True where the user named the file on the command line: it may be a pipe then.

    Raises
    ------
    InputError
        No such file, no regular one, not UTF-8, or not TOML; with the line.
    """
    return parse_toml(toml_text(path, file, from_user=from_user), file)


def toml_text(path: Path, file: str, *, from_user: bool = False) -> str:
    """Return the text of a TOML file, not looked into yet; the parameters and errors are those of `read_toml`."""
    try:
        content = read_given(path, TOML) if from_user else read_regular(path, file, limit=TOML)
        return content.decode("utf-8-sig")  # Windows editors write a byte-order mark
    except FileNotFoundError:
        raise InputError.at(
            FaultCode.FILE_MISSING, file, "", "no such file", f"write it, or correct the path ({path.parent})"
        ) from None
    except IsADirectoryError:
        raise InputError.at(
            FaultCode.FILE_KIND, file, "", "this is a folder, not a file", "give the file in it"
        ) from None
    except PermissionError:
        raise InputError.at(
            FaultCode.FILE_UNREADABLE, file, "", "no permission to read the file", "change its permissions"
        ) from None
    except OSError as error:  # links in a circle, a disk that fails
        reason = f"the file cannot be read: {error.strerror}"
        raise InputError.at(FaultCode.FILE_UNREADABLE, file, "", reason, "replace it by a regular file") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InputError.at(
            FaultCode.ENCODING_WRONG, file, f"line {line}", "the text is not UTF-8", "save the file as UTF-8"
        ) from None
    except ValueError:
        raise InputError.at(
            FaultCode.NAME_INVALID, repr(file), "", "no such file: its name contains a NUL", "correct the name"
        ) from None


def parse_toml(text: str, file: str) -> dict[str, Any]:
    """Return what a text of TOML holds, in a time that grows with its length alone.

    Parameters
    ----------
    text : of the file.
    file : how to call it in a fault.

    Raises
    ------
    InputError
        It is not TOML, or nests or holds more than any of our files needs.

    Examples
    --------
    >>> parse_toml('a."b.c" = "1.2.3"', "x.toml")
    {'a': {'b.c': '1.2.3'}}
    >>> parse_toml("[" + ".".join("a" * 99) + "]", "x.toml")
    Traceback (most recent call last):
    stiffcal.errors.InputError: x.toml: line 1: tables or lists are nested too deeply; reduce the nesting \
[size-exceeded]
    """
    keys = _without_strings(text)
    deep = _DEEP_KEY.search(keys)
    if deep is not None:
        place = f"line {keys.count(chr(10), 0, deep.start()) + 1}"
        raise InputError.at(FaultCode.SIZE_EXCEEDED, file, place, _DEEP, "reduce the nesting")
    try:
        document = tomllib.loads(text)
    except RecursionError:
        raise InputError.at(FaultCode.SIZE_EXCEEDED, file, "", _DEEP, "reduce the nesting") from None
    except tomllib.TOMLDecodeError as error:
        parsers_words = str(error)  # all that tomllib gives: it has neither codes nor fields
        match = _PLACE.search(parsers_words)
        place = match["place"] if match else ""
        complaint = parsers_words[: match.start()] if match else parsers_words
        if place == "end of document":
            place = f"line {text.rstrip().count(chr(10)) + 1}"
        raise InputError.at(
            FaultCode.SYNTAX_INVALID,
            file,
            place,
            f"not valid TOML: {complaint[:1].lower()}{complaint[1:]}",
            _SYNTAX_MEND,
        ) from None
    except ValueError:  # of more digits than Python reads at all
        reason = "an integer with thousands of digits"
        raise InputError.at(FaultCode.VALUE_INVALID, file, "", reason, "write a plausible number") from None
    _check_sizes(document, file)
    raise_faults(list(islice(name_faults(document, file), MOST_ODD_NAMES)))
    return document


def _without_strings(text: str) -> str:
    """Return a text of TOML on the same lines without what its strings and comments hold.

    A dot in them is no dot; one that is not closed reaches to where the parser refuses it. One pattern for a whole
    string would need a possessive group, which Python before 3.11.5 ends too early, or memory for each character.
    """
    kept = []
    at = 0
    while (opening := _OPENING.search(text, at)) is not None:
        ends = _ENDS[opening[0]].finditer(text, opening.end())
        end = next((sign for sign in ends if not sign[0].startswith("\\")), None)
        past = len(text) if end is None else end.start() if end[0] == "\n" else end.end()
        kept += [text[at : opening.start()], '"', "\n" * text.count("\n", opening.start(), past)]
        at = past
    return "".join([*kept, text[at:]])


def parse_for_editing(text: str, file: str, check: Callable[[dict[str, Any]], object]) -> TOMLDocument:
    """Return a text of TOML with its comments, to be changed and written again.

    Parameters
    ----------
    text : of the file.
    file : how to call it in a fault.
    check : raises where the document is none of its kind. Only one that passes, with no more dotted keys, nor empty
        lines in a row, than a table has entries, is parsed with its comments: that parser's time grows with the cube
        of a key's parts, and with the square of both numbers (1000 dotted keys: 2 s).

    Raises
    ------
    InputError
        As `parse_toml` and `check` raise it.
    """
    check(parse_toml(text, file))
    n_dotted = sum(1 for _ in _DOTTED_KEY.finditer(_without_strings(text)))
    ENTRIES.check(n_dotted, file, "keys with dots", "write tables, [a.b], in place of them")
    in_a_row = groupby(text.split("\n")[:-1], key=lambda line: not line.strip(" \t\r"))
    n_empty = max((len(list(lines)) for empty, lines in in_a_row if empty), default=0)
    ENTRIES.check(n_empty, file, "empty lines in a row", "delete empty lines")
    import tomlkit

    return tomlkit.parse(text)


def _check_sizes(document: dict[str, Any], file: str) -> None:
    """Refuse what is nested beyond all use, and whole numbers that TOML does not have."""
    waiting: list[tuple[tuple[int | str, ...], Any]] = [((), document)]
    while waiting:
        place, value = waiting.pop()
        if len(place) > MOST_NESTED:
            raise InputError.at(FaultCode.SIZE_EXCEEDED, file, key_path(place[:3]), _DEEP, "reduce the nesting")
        if isinstance(value, dict | list):
            limit = RUNS if place and place[-1] in _MANY else ENTRIES
            limit.check(len(value), file, key_path(place, document))
        if isinstance(value, dict):
            waiting += [((*place, key), item) for key, item in value.items()]
        elif isinstance(value, list):
            waiting += [((*place, index), item) for index, item in enumerate(value)]
        elif isinstance(value, int) and value not in WHOLE_NUMBERS:
            # a hexadecimal one of thousands of digits is read, and Python does not write it out
            n_digits = 1 + int(math.log10(2) * (value.bit_length() - 1))
            reason = f"an integer with about {n_digits} digits"
            raise InputError.at(
                FaultCode.VALUE_INVALID, file, key_path(place, document), reason, "write a plausible number"
            )
        elif isinstance(value, float) and LARGEST < abs(value) < math.inf:
            reason = f"{value:g} is larger than any plausible value"
            raise InputError.at(
                FaultCode.VALUE_INVALID, file, key_path(place, document), reason, "write it in SI units"
            )
        elif isinstance(value, float) and 0.0 < abs(value) < SMALLEST:
            reason = f"{value:g} is smaller than any plausible value"
            raise InputError.at(
                FaultCode.VALUE_INVALID,
                file,
                key_path(place, document),
                reason,
                "write 0, or the intended number",
            )


def validate(document: dict[str, Any], file: str, model: type[Model]) -> Model:
    """Check a document against its type.

    Raises
    ------
    InputError
        With one fault per wrong key.
    """
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise InputError(*faults_of(error, file, model, document)) from None
