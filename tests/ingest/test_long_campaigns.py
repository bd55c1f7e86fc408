"""The tool that measures long campaigns, with two runs: `python -m tests.long_campaigns` takes thousands."""

from __future__ import annotations

from pathlib import Path

from stiffcal.commands.ingest import ingest_campaign
from stiffcal.table_layout.text import text_layout
from tests.long_campaigns.campaign import write_head, write_runs
from tests.long_campaigns.measure import cost_of


def test_runs_that_are_added_are_read_and_measured(tmp_path: Path) -> None:
    folder = tmp_path / "long"
    write_head(folder)
    write_runs(folder, 1, 2)
    text_layout.cache_clear()
    result = ingest_campaign(folder)
    assert text_layout.cache_info().misses == 2  # of each log once, though header and rows are read apart
    assert [(run.id, run.n_states) for run in result.runs] == [("run1", 5)]
    write_runs(folder, 2, 3)
    cost = cost_of(folder, "ingest")
    assert (cost.code, cost.logs_opened) == (0, 4)
    assert cost.log_bytes == sum(path.stat().st_size for path in (folder / "raw").iterdir())
