"""Logs that are one JSON document: ``{"rows": [{"t": 0.0, "Fx": 1.0}, …]}``."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from stiffcal.campaign.toml.typed import Name, TomlTable
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import Batch, FuzzInput, Header, Options, Reader, WantedColumns, check_columns, check_options


class JsonRowsOptions(TomlTable):
    """Where in the document the rows lie.

    Attributes
    ----------
    key : the list that holds them; "rows" where left out.
    """

    key: Name | None = None


def _write_fuzz_input(path: Path) -> None:
    path.write_text(json.dumps({"rows": [{"t": 0.1 * k, "Fx": 1.0 * k, "run": "a"} for k in range(20)]}), "utf-8")


class JsonRowsReader(Reader):
    """Reads a JSON document whose rows are objects."""

    name = "jsonrows"
    endings = (".jrows",)
    options = JsonRowsOptions
    fuzz_inputs = (FuzzInput(".jrows", _write_fuzz_input, ("t", "Fx"), ("run",)),)

    def recognises(self, path: Path) -> bool:
        """Return True for the format's ending."""
        return path.suffix.lower() in self.endings

    def read_header(
        self, path: Path, options: Options, display_name: str = "", wanted: WantedColumns | None = None
    ) -> Header:
        """Return the keys of the first row."""
        rows = _rows(path, options, display_name or str(path))
        columns = tuple(rows[0])
        if wanted is not None:
            check_columns(wanted, columns, display_name, "rows")
        return Header(columns, {}, len(rows))

    def read_batches(
        self, path: Path, options: Options, wanted: WantedColumns, display_name: str = ""
    ) -> Iterator[Batch]:
        """Yield all rows at once."""
        rows = _rows(path, options, display_name)
        check_columns(wanted, tuple(rows[0]), display_name, "rows")
        try:
            numbers = {name: np.array([float(row[name]) for row in rows]) for name in wanted.numbers}
            texts = {name: [str(row[name]) for row in rows] for name in wanted.texts}
        except (KeyError, TypeError, ValueError):
            raise InputError.at(FaultCode.CELL_EMPTY, display_name, "", "a row lacks a number", "log again") from None
        if not all(np.isfinite(values).all() for values in numbers.values()):
            raise InputError.at(FaultCode.NUMBER_INVALID, display_name, "", "a number is not finite", "log again")
        yield Batch(1, numbers, texts)

    def place_of_row(self, path: Path, options: Options, row: int) -> str:
        """Return ``row n``."""
        return f"row {row}"


def _rows(path: Path, options: Options, display_name: str) -> list[dict[str, float | str]]:
    check_options(options, JsonRowsOptions, "jsonrows", display_name)
    try:
        document = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, "", "this is not JSON", "log again") from None
    rows = document.get(str(options.get("key") or "rows")) if isinstance(document, dict) else None
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise InputError.at(FaultCode.LOG_PART_MISSING, display_name, "", "no list of rows", "name it: jsonrows.key")
    return rows


READER = JsonRowsReader()
