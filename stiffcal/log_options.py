"""The options of a log format that a manifest states, held against what the format declares."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence

from stiffcal.campaign.toml.explain import plain_type
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import Options

_KINDS = {str: "text", int: "a whole number", float: "a number", bool: "true or false", list: "a list"}


def check_options(
    options: Options, table: type[TomlTable], name: str, display_name: str, further: Mapping[str, type] | None = None
) -> None:
    """Raise `InputError` for an option that `table` and `further` (not of the manifest) lack, or of the wrong type."""
    option_types = {key: plain_type(option.annotation) for key, option in table.model_fields.items()} | dict(
        further or {}
    )
    faults = []
    for key, value in options.items():
        place = f"{name}.{key}"
        if key not in option_types:
            faults.append(
                Fault(
                    FaultCode.KEY_UNKNOWN,
                    display_name,
                    place,
                    "no such option",
                    nearest_option(key, list(option_types), name),
                )
            )
        elif value is not None and (
            not isinstance(value, option_types[key]) or type(value) is bool is not option_types[key]
        ):
            kind = _KINDS.get(option_types[key], "of the right kind")
            faults.append(
                Fault(FaultCode.VALUE_INVALID, display_name, place, f"{value!r} is not {kind}", "correct the manifest")
            )
    if faults:
        raise InputError(*faults)


def nearest_option(key: str, known: Sequence[str], table: str) -> str:
    """Return a mend for an unknown option."""
    suggestions = difflib.get_close_matches(key, known, n=1, cutoff=0.5)
    return f"did you mean {table}.{suggestions[0]}?" if suggestions else f"options: {', '.join(known)}"
