"""Tables of displacements whose loads are in another unit than stated: a warning names the key."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from tests.laboratory.displacement_table import (
    DISPLACEMENTS,
    FORCES,
    campaign_of_robot,
    displacement_columns,
    write_displacement_campaign,
    write_table,
)

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


@pytest.mark.parametrize(
    ("robot", "softer", "newtons", "doubted"), [("ur5e", 0.4, 1e-3, True), ("r2000ic", 30.0, 1.0, False)]
)
def test_what_is_soft_depends_on_the_robot(
    robot: str, softer: float, newtons: float, doubted: bool, tmp_path: Path
) -> None:
    """A short arm with stiff drives in kN, up to 3 N/mm, and a long one with soft ones in N, 2 to 10 N/mm."""
    folder, columns = campaign_of_robot(robot, 12, tmp_path / "cell")
    columns |= {name: softer * columns[name] for name in DISPLACEMENTS}
    columns |= {name: newtons * columns[name] for name in FORCES}
    write_table(folder / "raw" / "table.csv", columns, decimals=6)
    warnings = reduce_campaign(load_campaign(folder), no_progress).result.warnings
    assert any(KEY in warning for warning in warnings) == doubted
