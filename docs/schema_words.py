"""JSON Schemas of `schemas/` in words: their types, with a link to what they name."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from docs.markdown import code

SCHEMAS = Path(__file__).parents[1] / "schemas"


def read_schema(name: str) -> dict[str, Any]:
    """Read one file of schemas/."""
    document: dict[str, Any] = json.loads((SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8"))
    return document


def type_of(entry: Mapping[str, Any]) -> str:
    """Return a schema's type in words."""
    if "$ref" in entry:
        name = entry["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in entry:
        return code(json.dumps(entry["const"]))
    if "enum" in entry:
        return ", ".join(code(json.dumps(choice)) for choice in entry["enum"])
    if "anyOf" in entry or "oneOf" in entry:
        return " or ".join(type_of(choice) for choice in entry.get("anyOf", entry.get("oneOf")))
    if "allOf" in entry:
        return " and ".join(type_of(choice) for choice in entry["allOf"])
    return plain_type(entry)


def plain_type(entry: Mapping[str, Any]) -> str:
    """Return the type of a schema that refers to no other."""
    kind = entry.get("type", "any")
    if isinstance(kind, list):
        return " or ".join(kind)
    if kind == "array":
        low, high = entry.get("minItems"), entry.get("maxItems")
        count = f"{low} " if low is not None and low == high else ""
        return f"list of {count}{type_of(entry.get('items', {}))}"
    inner = entry.get("additionalProperties")
    return f"table of {type_of(inner)}" if kind == "object" and isinstance(inner, Mapping) else str(kind)
