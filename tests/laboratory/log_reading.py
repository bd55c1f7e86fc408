"""Reading a log as a whole, and the one line that refuses it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.parsers.client import ParsedFile
from stiffcal.parsers.messages import LogHeader
from stiffcal.parsers.open_log import OpenLog, Parser
from stiffcal.readers import Batch, Reader, WantedColumns


def read_columns(
    reader: Reader, path: Path, options: Mapping[str, Any], wanted: WantedColumns, shown: str = ""
) -> dict[str, Any]:
    """Return the wanted columns of a log as arrays; the batches' rows are numbered on."""
    found: dict[str, list[Any]] = {name: [] for name in wanted.names}
    for batch in reader.read_batches(path, options, wanted, *([shown] if shown else [])):
        assert batch.first_row == len(found[wanted.names[0]]) + 1
        for name in wanted.names:
            found[name].extend(batch.numbers.get(name, batch.texts.get(name, ())))
    return {name: np.array(values) for name, values in found.items()}


def refusal(read: Callable[[], object], shown: str = "") -> str:
    """Return the one line with which an input is refused; it begins with the file as ``shown``."""
    with pytest.raises(InputError) as caught:
        read()
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{shown}: " if shown else "")
    return line


def parse_here(monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    """Have binary logs parsed in this process, in which parts can be replaced, and in batches of so many rows."""

    def header(file: ParsedFile, wanted: WantedColumns | None) -> LogHeader:
        with _parser(file)(file.path, file.options, file.display_name) as log:
            if wanted is not None:
                log.check(wanted)
            return log.header()

    def batches(file: ParsedFile, wanted: WantedColumns) -> Iterator[Batch]:
        with _parser(file)(file.path, file.options, file.display_name) as log:
            log.check(wanted)
            yield from log.batches(wanted)

    monkeypatch.setattr(OpenLog, "BATCH_ROWS", rows)
    monkeypatch.setattr(ParsedFile, "header", header)
    monkeypatch.setattr(ParsedFile, "batches", batches)


def _parser(file: ParsedFile) -> Parser:
    parser: Parser = import_module(f"stiffcal.parsers.{file.log_format}").open_log
    return parser
