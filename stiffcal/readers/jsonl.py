"""JSON lines (``.jsonl``, ``.ndjson``): an object a line, as web services, robot middleware and pandas write them.

No options. Each line is a row. A column is a key, inside objects and lists by its path: ``wrench.force.x``, ``q[0]``.
Columns are those of the first thousand lines; what a line lacks, or is ``null``, is an empty cell. Times may be ISO
8601 words. A line with the same key twice is refused.
"""

from __future__ import annotations

import json
from pathlib import Path

from stiffcal.campaign.typed import TomlTable
from stiffcal.readers import FuzzInput, Options, ParsedReader


class JsonlOptions(TomlTable):
    """Nothing to say yet: each line names its values itself."""


def _write_fuzz_input(path: Path) -> None:
    rows = ({"t": 0.01 * k, "ft": {"F": [k - 30.5, 0.0]}, "run": f"pose{k // 20}"} for k in range(60))
    path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")


class JsonlReader(ParsedReader):
    """Reads objects in batches of lines."""

    name = "jsonl"
    endings = (".jsonl", ".ndjson")
    options = JsonlOptions
    fuzz_inputs = (FuzzInput(".jsonl", _write_fuzz_input, ("t", "ft.F[0]"), ("run",)),)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``data row n``: empty lines are not counted."""
        return f"data row {row}"


READER = JsonlReader()
