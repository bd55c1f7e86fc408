"""Reading a TOML file: syntax faults with line and column, then the types, every fault at once."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from stiffcal.campaign.explain import faults_of
from stiffcal.errors import InputError

Model = TypeVar("Model", bound=BaseModel)

_PLACE = re.compile(r"\s*\(at (?P<place>line \d+, column \d+|end of document)\)$")


def read_toml(path: Path, file: str) -> dict[str, Any]:
    """Read a TOML document.

    Parameters
    ----------
    path : where it lies.
    file : how to call it in a fault.

    Raises
    ------
    InputError
        No such file, not UTF-8, or not TOML; with the line.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")  # Windows editors write a byte-order mark
    except FileNotFoundError:
        raise InputError.at(file, "", "no such file", f"write it, or correct the path ({path.parent})") from None
    except IsADirectoryError:
        raise InputError.at(file, "", "this is a folder, not a file", "name the file in it") from None
    except PermissionError:
        raise InputError.at(file, "", "the file may not be read", "change its permissions") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InputError.at(file, f"line {line}", "the text is not UTF-8", "save the file as UTF-8") from None
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        match = _PLACE.search(message)
        place = match["place"] if match else ""
        reason = message[: match.start()] if match else message
        if place == "end of document":
            place = f"line {text.rstrip().count(chr(10)) + 1}"
        raise InputError.at(
            file, place, f"this is not TOML: {reason[:1].lower()}{reason[1:]}", _syntax_mend(reason)
        ) from None


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


def _syntax_mend(reason: str) -> str:
    if "overwrite" in reason or "declare" in reason.lower() or "twice" in reason:
        return "a key or table stands there twice: keep one"
    if "Invalid value" in reason:
        return "put texts in quotes, write decimal points rather than commas"
    return "correct that line"
