"""The tool that measures long campaigns counts the logs that a command opens."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.long_campaigns.campaign import write_head, write_runs
from tests.long_campaigns.measure import cost_of


@pytest.mark.long
def test_the_tool_counts_logs_and_time(tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    write_head(folder)
    write_runs(folder, 1, 3)
    cost = cost_of(folder, "ingest")
    assert (cost.code, cost.logs_opened) == (0, 4)
    assert cost.log_bytes == sum(log.stat().st_size for log in (folder / "raw").iterdir())
    assert cost.processor_s > 0.1
