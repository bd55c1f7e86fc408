"""Parsing a log in the child process: its header, its rows, or the first of them."""

from __future__ import annotations

import importlib
from collections.abc import Generator
from contextlib import suppress
from types import ModuleType
from typing import TYPE_CHECKING

from stiffcal.bounded_work.messages import Document
from stiffcal.parsers.messages import LogRequest, batch_message, header_message, tables_message

if TYPE_CHECKING:
    from stiffcal.parsers.open_log import Parser


def prepare(values: Document) -> None:
    """Import the parser of a log's format, and its libraries."""
    for library in getattr(_module_of(values), "LIBRARIES", ()):
        with suppress(ImportError):
            importlib.import_module(library)


def answers(values: Document) -> Generator[tuple[bytes, int], None, None]:
    """Yield a log's tables, its header, or its rows, and the bytes that reading them has unpacked."""
    request = LogRequest.of(values)
    if request.asked == "tables":
        yield tables_message(_module_of(values).tables(request.path, request.display_name)), 0
        return
    open_log: Parser = _module_of(values).open_log
    with open_log(request.path, request.options, request.display_name) as log:
        if request.asked == "first rows" and request.wanted is not None:
            for batch in log.first_rows(request.wanted.names):
                yield batch_message(batch), log.unpacked
            return
        if request.wanted is not None:
            log.check(request.wanted)
        if request.wanted is None or request.asked == "header":
            yield header_message(log.header()), log.unpacked
            return
        for batch in log.batches(request.wanted):
            yield batch_message(batch), log.unpacked


def _module_of(values: Document) -> ModuleType:
    return importlib.import_module(f"stiffcal.parsers.{values['format']}")
