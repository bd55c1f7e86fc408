"""What several tests of mistakes in tables of absolute places share."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import ReducedCampaign, reduce_campaign
from tests.laboratory.changed_tables import CAMPAIGNS, Reduce, Table


@pytest.fixture
def reduced(tmp_path: Path) -> Reduce:
    """Return what is made of a bundled campaign whose table was changed."""

    def reduce(name: str, change: Callable[[Table], None]) -> ReducedCampaign:
        folder = Path(shutil.copytree(CAMPAIGNS / name, tmp_path / name, ignore=shutil.ignore_patterns("store")))
        file = folder / "raw" / "poses.csv"
        with file.open(encoding="utf-8") as lines:
            head, *rows = csv.reader(lines)
        table = {column: [float(row[k]) for row in rows] for k, column in enumerate(head)}
        change(table)
        text = [
            ["" if np.isnan(value) else f"{value:.9g}" for value in row] for row in zip(*table.values(), strict=True)
        ]
        file.write_text("\n".join(",".join(row) for row in [list(table), *text]) + "\n", encoding="utf-8")
        return reduce_campaign(load_campaign(folder), no_progress)

    return reduce
