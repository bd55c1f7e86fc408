"""Where a row of a table stands: its line in a text, its number alone in other formats."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.mistakes.absolute.table_rows import TableRows
from tests.laboratory.absolute_places import absolute_states
from tests.laboratory.changed_tables import CAMPAIGNS
from tests.laboratory.robots import six_axes


@pytest.mark.parametrize(("ending", "place"), [("csv", "run poses, row 2 (line 3)"), ("parquet", "run poses, row 2")])
def test_a_line_is_stated_where_the_format_has_lines(tmp_path: Path, ending: str, place: str) -> None:
    folder = Path(shutil.copytree(CAMPAIGNS / "01", tmp_path / "01", ignore=shutil.ignore_patterns("store")))
    manifest = folder / "campaign.toml"
    if ending == "parquet":
        pyarrow.parquet.write_table(
            pyarrow.csv.read_csv(folder / "raw" / "poses.csv"), folder / "raw" / "poses.parquet"
        )
        manifest.write_text(
            manifest.read_text(encoding="utf-8").replace("poses.csv", "poses.parquet"), encoding="utf-8"
        )
    rows = TableRows(load_campaign(folder), absolute_states(six_axes(), 3, 1))
    assert rows.file() == f"raw/poses.{ending}"
    assert rows.place(np.array([1])) == place
    assert rows.place(np.array([1, 2])) == f"{place} and others"
