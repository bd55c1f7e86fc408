"""The time of a log in two columns: seconds, and what is added to them."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from stiffcal.campaign.manifest.manifest_type import source_type
from stiffcal.campaign.manifest.source import TimeAxis
from stiffcal.reduction.logs.log_rows import read_rows


@pytest.mark.parametrize(
    "written",
    [
        {"column": "s", "unit": "s", "fraction": "ns"},
        {"column": "s", "unit": "s", "fraction_unit": "ns"},
        {"column": "s", "unit": "s", "fraction": "s", "fraction_unit": "ns"},
        {"rate_hz": 50.0, "fraction": "ns", "fraction_unit": "ns"},
    ],
)
def test_a_fraction_needs_its_unit_and_the_time_that_it_is_added_to(written: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        TimeAxis.model_validate(written)


@pytest.mark.parametrize(("column", "unit", "second"), [("s", "s", "36930"), ("clock", "iso8601", "10:15:30")])
def test_both_columns_count(tmp_path: Path, column: str, unit: str, second: str) -> None:
    (tmp_path / "log.csv").write_text(f"{column},ms,Fx\n{second},250,1\n{second},500,2\n", encoding="utf-8")
    time = {"column": column, "unit": unit, "fraction": "ms", "fraction_unit": "ms"}
    wrench = {"columns": ["Fx"], "direction": [1, 0, 0], "axes": "base", "point": "tool"}
    source = source_type().model_validate({"format": "csv", "sampling": "time", "time": time, "wrench": wrench})
    (rows,) = read_rows(tmp_path, "log", source, {"": "log.csv"})
    assert rows.time.tolist() == [36930.25, 36930.5]
