"""Tables of displacements whose loads stand some rows off: named, and a joint that lags behind its load is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_changes import InputChange
from stiffcal.ingest.reading.reducing import reduce_campaign
from tests.laboratory.displacement_table import DISPLACEMENTS, ramps
from tests.laboratory.displacement_table import write_displacement_campaign as write

UP, UP_AND_DOWN = np.linspace(0.0, 1.0, 5), np.array([0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0])


@pytest.mark.parametrize("by", [1, -1, 2])
def test_of_a_load_that_goes_up_in_each_pose(by: int, tmp_path: Path) -> None:
    columns = ramps(12, UP)
    columns |= {name: np.roll(columns[name], by) for name in DISPLACEMENTS}
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(write(tmp_path / "cell", columns)), no_progress)
    (change,) = refused.value.faults[0].changes
    # loads that are moved the other way are next to the same displacements, but for their poses
    assert change.kind == "row-order"
    assert change in {InputChange(change.kind, (name,), (n,)) for name, n in
                      (("displacements", -float(by)), ("loads", float(by)))}  # fmt: skip


def test_joints_that_lag_behind_their_load_are_let_pass(tmp_path: Path) -> None:
    """A row further down, the load would be nearly that which the displacement follows."""
    lag = 0.2 * np.array([0.0, -0.75, -1.0, -0.75, -0.5, 0.75, 1.0, 0.75, 0.5])
    folder = write(tmp_path / "cell", ramps(60, UP_AND_DOWN, lag))
    assert reduce_campaign(load_campaign(folder), no_progress).result.n_states == 60 * len(UP_AND_DOWN)
