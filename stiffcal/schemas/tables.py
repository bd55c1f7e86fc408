"""JSON Schemas of the store's tables: ``python -m stiffcal.schemas.tables schemas/``.

Each describes one row. They are made from what the tables are declared to hold: `stiffcal.store.tables`, and
``tables.py`` of a kind of experiment.

In the Parquet files a missing number is NaN. JSON has no NaN: there it is null, and so the schemas allow null.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa

from stiffcal.kinds.declared_tables import declared_tables
from stiffcal.store.declared_table import MEANING, UNIT, DeclaredTable, pattern_of

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_TYPES = {"double": "number", "int64": "integer", "bool": "boolean", "string": "string"}


def table_schema(table: DeclaredTable) -> dict[str, Any]:
    """Return the JSON Schema of a row of a table.

    Examples
    --------
    >>> from stiffcal.store.tables import STATES
    >>> table_schema(STATES)["properties"]["Fx_N"]["unit"]
    'N'
    """
    names = table.schema.names
    return {
        "$schema": DIALECT,
        "title": table.name,
        "description": f"{table.meaning} Missing numbers are NaN in the file, null here.",
        "type": "object",
        "properties": {field.name: _column(field) for field in table.schema if "<" not in field.name},
        "patternProperties": {
            _pattern(field.name, names): {"title": field.name, **_column(field)}
            for field in table.schema
            if "<" in field.name
        },
        "required": list(table.required),
        "additionalProperties": False,
    }


def _column(field: pa.Field) -> dict[str, Any]:
    kind, unit = str(field.type), field.metadata[UNIT].decode()
    description: dict[str, Any] = {
        "description": field.metadata[MEANING].decode(),
        "type": [_TYPES[kind], "null"] if field.nullable else _TYPES[kind],
    }
    return description | ({"unit": unit} if unit else {}) | {"parquet": kind}


def _pattern(column: str, columns: list[str]) -> str:
    """Return the regular expression of a column's names: what stands in <…> is free, unless it is another column's."""
    members = pattern_of(column)
    narrower = [pattern_of(name) for name in columns if name != column and re.fullmatch(members, name)]
    return "^" + "".join(f"(?!{expression}$)" for expression in narrower) + members + "$"


def schema_texts() -> dict[str, str]:
    """Return file name to JSON Schema of every table, as they stand in `schemas/`."""
    return {
        f"{table.name.replace('/', '_')}.table.schema.json": json.dumps(
            table_schema(table), indent=2, ensure_ascii=False
        )
        + "\n"
        for table in declared_tables()
    }


if __name__ == "__main__":
    for file, text in schema_texts().items():
        (Path(sys.argv[1]) / file).write_text(text, encoding="utf-8", newline="\n")
