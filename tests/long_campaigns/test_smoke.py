"""The tool that measures long campaigns writes tables and logs that its commands can read."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.long_campaigns.__main__ import measure_gigabytes, measure_rows, measure_states


@pytest.mark.long
def test_large_tables_and_logs_are_identified(tmp_path: Path) -> None:
    assert {cost.code for cost in measure_states("600", tmp_path / "table").values()} == {0}
    assert {cost.code for cost in measure_rows("600", tmp_path / "rows").values()} == {0}
    assert {cost.code for cost in measure_gigabytes("0.001", tmp_path / "logs").values()} == {0}
