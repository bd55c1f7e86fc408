"""From pydantic's errors to faults in the lab's words: file, key path, what was found, what to write."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from stiffcal.campaign.toml.typed import TomlTable, WrongValueError
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode

Path = Sequence[int | str]

_EXPECTED = {
    "string_type": "a text in quotes",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
    "tuple_type": "a list in square brackets",
    "list_type": "a list in square brackets",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "finite_number": "a finite number",
}
MOST_REPORTED = 100  # faults of one file
_BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


def faults_of(error: ValidationError, file: str, model: type[BaseModel], document: Mapping[str, Any]) -> list[Fault]:
    """Turn a pydantic error into faults, one per wrong key.

    Parameters
    ----------
    error : what pydantic raised.
    file : the file as the user named it.
    model : the root type that was read.
    document : the file's contents, to name runs and joints by what the user called them.
    """
    details: list[dict[str, Any]] = [dict(detail) for detail in error.errors(include_url=False)]
    unidentified = len(details) - MOST_REPORTED
    details = details[:MOST_REPORTED]
    unknown: list[Path] = [detail["loc"] for detail in details if detail["type"] == "extra_forbidden"]
    misspelt = {(*location[:-1], _nearest(location, model)) for location in unknown}
    faults = []
    for detail in details:
        if detail["type"] == "missing" and detail["loc"] in misspelt:
            continue  # the misspelt key is a fault already
        reason, mend = _words(detail, model)
        faults.append(Fault(_code(detail), file, key_path(detail["loc"], document), reason, mend))
    if unidentified > 0:
        faults.append(Fault(FaultCode.MORE_FAULTS, file, "", f"{unidentified} more faults", "correct these first"))
    return faults


def key_path(location: Path, document: Mapping[str, Any] | None = None) -> str:
    """Write a place in a TOML file the way a person would look for it.

    List entries are counted from 1 and carry their `id` or `name` where they have one.

    Examples
    --------
    >>> key_path(("runs", 1, "files", "ft"), {"runs": [{}, {"id": "pose02"}]})
    'runs[2] (pose02).files.ft'
    """
    text = ""
    value: Any = document
    for step in location:
        if isinstance(step, int):
            value = value[step] if isinstance(value, list) and step < len(value) else None
            label = (value.get("id") or value.get("name") or value.get("type")) if isinstance(value, dict) else None
            text += f"[{step + 1}]" + (f" ({label})" if label else "")
        else:
            value = value.get(step) if isinstance(value, dict) else None
            text += ("." if text else "") + str(step)
    return text


def _code(detail: Mapping[str, Any]) -> FaultCode:
    """Return the family of one of pydantic's errors, by its type."""
    cause = detail.get("ctx", {}).get("error")
    if isinstance(cause, WrongValueError):
        return cause.code
    return _CODES.get(str(detail["type"]), FaultCode.VALUE_INVALID)


_CODES = {"extra_forbidden": FaultCode.KEY_UNKNOWN, "missing": FaultCode.KEY_MISSING}


def _words(detail: dict[str, Any], model: type[BaseModel]) -> tuple[str, str]:
    kind = str(detail["type"])
    context = detail.get("ctx", {})
    written = _shown(detail.get("input"))
    if isinstance(context.get("error"), WrongValueError):
        mistake = context["error"]
        return mistake.reason, mistake.mend
    if kind == "extra_forbidden":
        return _unknown_key(detail["loc"], model)
    if kind == "missing":
        return f'the key "{detail["loc"][-1]}" is missing', _missing_mend(detail["loc"], model)
    if kind == "literal_error":
        return f"{written} is not one of the choices", f"write one of {context.get('expected', '')}".replace("'", '"')
    if kind in _BOUNDS:
        key, word = _BOUNDS[kind]
        return f"{written} is out of range", f"write a number {word} {context.get(key)}"
    if kind == "string_too_short":
        return "the text is empty", "write a name"
    if kind in ("too_short", "too_long"):
        return f"found {context.get('actual_length', 'the wrong number of')} entries", "give the required number"
    return f"found {written}", f"write {_EXPECTED.get(kind, 'a value of the right kind')}"


def _shown(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "…"


def _unknown_key(location: Path, model: type[BaseModel]) -> tuple[str, str]:
    wrong = str(location[-1])
    table = _table_at(location[:-1], model)
    reason = f'unknown key "{wrong}"'
    near = _nearest(location, model)
    keys = ", ".join(_keys(table))
    if near is not None:
        return reason, f'did you mean "{near}"? The keys here are {keys}'
    return reason, f"remove it; the keys here are {keys}"


def _nearest(location: Path, model: type[BaseModel]) -> str | None:
    """Return the valid key that an unknown one most likely stands for."""
    wrong = str(location[-1])
    table = _table_at(location[:-1], model)
    if table is not None and issubclass(table, TomlTable) and wrong in table.look_alikes:
        return table.look_alikes[wrong]
    suggestions = get_close_matches(wrong, _keys(table), n=1, cutoff=0.5)
    return suggestions[0] if suggestions else None


def _missing_mend(location: Path, model: type[BaseModel]) -> str:
    table = _table_at(location[:-1], model)
    if table is not None and str(location[-1]) == "schema":
        schema_fields = [field for name, field in table.model_fields.items() if "schema" in (name, field.alias)]
        choices = get_args(schema_fields[0].annotation)
        return f"write {toml_text.pair('schema', choices[0])} as the first line" if choices else "add it"
    return "add it"


def _keys(table: type[BaseModel] | None) -> list[str]:
    return [field.alias or name for name, field in table.model_fields.items()] if table is not None else []


def _table_at(location: Path, model: type[BaseModel]) -> type[BaseModel] | None:
    """Follow a key path through the types to the table it names."""
    table: Any = model
    for step in location:
        if isinstance(table, type) and issubclass(table, BaseModel):
            fields = {field.alias or name: field for name, field in table.model_fields.items()}
            if step not in fields:
                return None
            table = _bare(fields[str(step)].annotation)
        elif get_origin(table) is dict:
            table = _bare(get_args(table)[1])
        elif get_origin(table) in (list, tuple):
            table = _bare(get_args(table)[0])
        else:
            return None
    return table if isinstance(table, type) and issubclass(table, BaseModel) else None


def _bare(annotation: Any) -> Any:
    """Strip `Annotated` and `| None` from a type."""
    origin = get_origin(annotation)
    if origin is typing.Annotated:
        return _bare(get_args(annotation)[0])
    if origin in (Union, types.UnionType):
        parts = [member for member in get_args(annotation) if member is not type(None)]
        return _bare(parts[0])
    return annotation


def plain_type(annotation: Any) -> type:
    """Return the Python type of a field's values, without `None`, bounds and choices.

    Examples
    --------
    >>> plain_type(list[str] | None), plain_type(typing.Literal[".", ","] | None)
    (<class 'list'>, <class 'str'>)
    """
    bare = _bare(annotation)
    if get_origin(bare) is typing.Literal:
        return type(get_args(bare)[0])
    plain = get_origin(bare) or bare
    return plain if isinstance(plain, type) else object
