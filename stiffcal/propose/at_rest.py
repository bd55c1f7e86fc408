"""Tables that come through a pipe, written down so that they can be read twice."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from stiffcal.campaign.toml.reach import check_given
from stiffcal.files import is_given


@contextmanager
def at_rest(tables: Sequence[Path]) -> Iterator[list[Path]]:
    """Hand out files that can be read twice: what comes through a pipe (``--from <(zcat …)``) is written down first."""
    with tempfile.TemporaryDirectory(prefix="stiffcal-init-") as place:
        own_tables = []
        for number, table in enumerate(map(Path, tables), start=1):
            with suppress(OSError):  # what is not there is named by its reader
                check_given(table)
            if is_given(table) and not table.is_file():
                kept = Path(place) / ("table.csv" if len(tables) == 1 else f"table-{number}.csv")
                with table.open("rb") as pipe, kept.open("wb") as file:
                    shutil.copyfileobj(pipe, file)
                table = kept
            own_tables.append(table)
        yield own_tables
