"""Tables of displacements with one axis of a reading wrong: named, where it seemed that poses were too few."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reading.reducing import reduce_campaign
from tests.laboratory.displacement_table import (
    DISPLACEMENTS,
    FORCES,
    Columns,
    displacement_columns,
    write_displacement_campaign,
)


def changes_named(
    folder: Path, change: Callable[[Columns], None], code: FaultCode = FaultCode.WRENCH_MISMATCH
) -> tuple[InputChange, ...]:
    """Return what is named of a table with a mistake."""
    columns = displacement_columns(12)
    change(columns)
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(write_displacement_campaign(folder / "cell", columns)), no_progress)
    (fault,) = refused.value.faults
    assert fault.code is code
    return fault.changes


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_one_force_with_the_other_sign(axis: str, tmp_path: Path) -> None:
    def turned(columns: Columns) -> None:
        columns[f"F{axis}"] = -columns[f"F{axis}"]

    assert changes_named(tmp_path, turned) == (InputChange("wrench-sign", (f"F{axis}",)),)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_one_displacement_with_the_other_sign(axis: str, tmp_path: Path) -> None:
    def turned(columns: Columns) -> None:
        columns[f"d{axis}"] = -columns[f"d{axis}"]

    axes = tuple(f"-{other}" if other == axis.upper() else other for other in "XYZ")
    assert changes_named(tmp_path, turned) == (InputChange("displacement-axes", axes),)


def test_displacements_in_another_order(tmp_path: Path) -> None:
    def turned(columns: Columns) -> None:
        columns["dx"], columns["dy"], columns["dz"] = columns["dz"], columns["dx"], columns["dy"]

    assert changes_named(tmp_path, turned) == (InputChange("displacement-axes", ("Y", "Z", "X")),)


@pytest.mark.parametrize("moved", ["loads", "displacements"])
@pytest.mark.parametrize("by", [1, -2])
def test_columns_in_other_rows_than_the_others(moved: str, by: int, tmp_path: Path) -> None:
    def shifted(columns: Columns) -> None:
        for name in FORCES if moved == "loads" else DISPLACEMENTS:
            columns[name] = np.roll(columns[name], -by)

    change = InputChange("row-order", (moved,), (float(by),))
    assert changes_named(tmp_path, shifted, FaultCode.KINEMATICS_MISMATCH) == (change,)
