"""Orientations that the manifest names and that no row has: one warning, as positions alone count then."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.ingest.checks.loaded import check_campaign
from tests.laboratory.small_campaign import write_small_campaign


@pytest.mark.parametrize(("empty_rows", "named"), [(0, False), (3, False), (10**6, True)])
def test_a_column_of_gaps(tmp_path: Path, empty_rows: int, named: bool) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)
    (log,) = (folder / "raw").glob("*.csv")
    head, *rows = [line.split(",") for line in log.read_text().splitlines()]
    for row in rows[:empty_rows]:
        row[head.index("rx")] = ""
    log.write_text("".join(",".join(row) + "\n" for row in (head, *rows)))
    warnings = [line for line in check_campaign(folder).warnings if line.startswith("sources.table.pose: no state")]
    assert len(warnings) == named
