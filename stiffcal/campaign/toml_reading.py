"""Reading a TOML file: syntax faults with line and column, then the types, every fault at once."""

from __future__ import annotations

import math
import re
import tomllib
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from stiffcal.campaign.explain import faults_of, key_path
from stiffcal.campaign.name_checks import name_faults
from stiffcal.campaign.reach import read_given
from stiffcal.errors import InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.limits import ENTRIES, RUNS, TOML

Model = TypeVar("Model", bound=BaseModel)

LARGEST = 1e30  # in SI: what is larger overflows somewhere in the physics, and is a slip
SMALLEST = 1e-100  # its square is still a number; below it only slips are written
MOST_DOTS = 100  # in one key
MOST_ODD_NAMES = 20  # that are shown, each on its line
MOST_NESTED = 20  # tables in tables: twice what any of our files needs
WHOLE_NUMBERS = range(-(2**63), 2**63)  # TOML 1.0: what a reader has to hold
_MANY = frozenset({"runs", "exclude", "rows", "campaigns", "parameters"})
"""Keys of lists and tables that grow with what was measured; all others are a robot's or an instrument's."""
_SYNTAX_MEND = "correct that line: text in quotes, decimal points, each key and table once"
_DEEP = "tables or lists are nested too deeply"

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
    try:
        content = read_given(path, TOML) if from_user else read_regular(path, file, limit=TOML)
        text = content.decode("utf-8-sig")  # Windows editors write a byte-order mark
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
    for number, row in enumerate(text.splitlines(), start=1):  # the parser's time grows with the square of these
        key = row.partition("=")[0] if "=" in row else row if row.startswith("[") and "," not in row else ""
        if key.count(".") > MOST_DOTS:
            raise InputError.at(FaultCode.SIZE_EXCEEDED, file, f"line {number}", _DEEP, "reduce the nesting")
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
            reason = f"an integer with {len(str(abs(value)))} digits"
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
