"""JSON (``.jsonl``, ``.ndjson``, ``.json``): an object a line, or one document that holds a table.

Lines are what web services, robot middleware and pandas write. A document holds a list of objects, columns as lists of
equal length, or what pandas writes by itself (``orient`` columns or split).

No options. Each line, or entry, is a row. A column is a key, inside objects and lists by its path: ``wrench.force.x``,
``q[0]``. Columns are those of the first thousand rows; what a row lacks, or is ``null``, is an empty cell. Times may be
ISO 8601 words. An object with the same key twice is refused.
"""

from __future__ import annotations

import json
from pathlib import Path

from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.parsers.signatures import begins_like_json
from stiffcal.readers import FuzzInput, Options, ParsedReader


class JsonlOptions(TomlTable):
    """Nothing to say yet: each line names its values itself."""


def _write_fuzz_input(path: Path) -> None:
    rows = ({"t": 0.01 * k, "ft": {"F": [k - 30.5, 0.0]}, "run": f"pose{k // 20}"} for k in range(60))
    path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")


def _write_document(path: Path) -> None:
    table = {
        "t": [0.01 * k for k in range(60)],
        "ft": {"F": [k - 30.5 for k in range(60)]},
        "run": [f"pose{k // 20}" for k in range(60)],
    }
    path.write_text(json.dumps(table), encoding="utf-8")


class JsonlReader(ParsedReader):
    """Reads objects in batches of lines."""

    name = "jsonl"
    endings = (".jsonl", ".ndjson", ".json")
    options = JsonlOptions
    fuzz_inputs = (
        FuzzInput(".jsonl", _write_fuzz_input, ("t", "ft.F[0]"), ("run",)),
        FuzzInput(".json", _write_document, ("t", "ft.F"), ("run",)),
    )

    def recognises(self, path: Path) -> bool:
        """Return True for the usual endings, and for text that begins as JSON does."""
        return super().recognises(path) or begins_like_json(path)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``data row n``: empty lines are not counted."""
        return f"data row {row}"


READER = JsonlReader()
