"""The reference page of the JSON documents: each with its keys, then the types that they hold."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from typing import Any, get_args, get_type_hints

from docs.field_words import meanings_of
from docs.markdown import cell, code, table
from docs.schema_words import read_schema, type_of
from stiffcal.documents import results_by_name
from stiffcal.schemas.documents import DOCUMENTS


def document_page() -> str:
    """Keys of the JSON documents that the commands print with `--json`, and of the types in them."""
    parts = [
        "# JSON documents\n",
        "What each command prints with `--json`. Numbers are in SI units. The JSON Schemas are",
        "`schemas/NAME.document.schema.json` of the source.\n",
    ]
    definitions: dict[str, Mapping[str, Any]] = {}
    kinds: dict[str, type] = {}
    for name, kind in sorted(DOCUMENTS.items()):
        schema = read_schema(f"{name}.document")
        definitions |= schema.get("$defs", {})
        kinds |= {one.__name__: one for one in _dataclasses_in(kind)}
        parts += [f"## {name}\n", _text(schema.get("description", "")) + "\n", _keys(schema, kind)]
    parts.append("## Types of these keys\n")
    for name, definition in sorted(definitions.items()):
        parts += [f"### {name}\n", _text(definition.get("description", "")) + "\n"]
        parts.append(_keys(definition, kinds[name]) if name in kinds else f"One of: {type_of(definition)}\n")
    return "\n".join(parts)


def _keys(schema: Mapping[str, Any], kind: type) -> str:
    meanings = meanings_of(kind)
    rows = [
        (code(key), type_of(entry), _text(entry.get("description") or meanings.get(key, "")))
        for key, entry in schema.get("properties", {}).items()
    ]
    return table(("key", "type", "meaning"), rows)


def _text(words: str) -> str:
    """Return a docstring in a cell: code as Markdown has it, and JSON's word for nothing."""
    return cell(re.sub(r"\bNone\b", "null", words.replace("``", "`")))


def _dataclasses_in(kind: Any, known: set[type] | None = None) -> Iterator[type]:
    """Yield the dataclasses that a type holds, at any depth, each once."""
    known = set() if known is None else known
    if isinstance(kind, type) and is_dataclass(kind):
        if kind in known:
            return
        known.add(kind)
        yield kind
        for hint in (*get_type_hints(kind).values(), *results_by_name(kind).values()):
            yield from _dataclasses_in(hint, known)
    for inner in get_args(kind):
        yield from _dataclasses_in(inner, known)
