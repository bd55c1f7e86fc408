"""Tables of displacements whose loads are in another unit than stated: a warning names the key."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reducing import reduce_campaign
from tests.laboratory.displacement_table import FORCES, displacement_columns, write_displacement_campaign

KEY = "sources.table.wrench.units.force"


@pytest.mark.parametrize(("factor", "doubted"), [(1e-3, True), (1.02e-4, True), (1.0, False), (0.225, False)])
def test_loads_in_kilonewtons_or_tonnes_called_newtons(factor: float, doubted: bool, tmp_path: Path) -> None:
    """A factor of four (lbf) makes a robot that could be."""
    columns = displacement_columns(12)
    for name in FORCES:
        columns[name] *= factor
    # the table holds four decimals, of less than a newton too few
    folder = write_displacement_campaign(tmp_path / "cell", columns)
    warnings = reduce_campaign(load_campaign(folder), no_progress).result.warnings
    assert any(KEY in warning for warning in warnings) == doubted
