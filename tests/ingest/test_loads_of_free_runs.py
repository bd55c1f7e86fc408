"""A run that was to be unloaded, and carries a load, is checked as a load run is."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reducing import reduce_campaign
from stiffcal.measurements.state_measures import StateMeasure
from tests.laboratory.small_campaign import write_small_campaign


def free_runs(folder: Path, sign: float) -> Path:
    """Write the small campaign with all runs free, their forces times a number."""
    write_small_campaign(folder)
    file = folder / "raw" / "states.csv"
    with file.open(encoding="utf-8") as lines:
        head, *rows = csv.reader(lines)
    forces = [head.index(name) for name in ("Fx", "Fy", "Fz")]
    for row in rows:
        for k in forces:
            row[k] = repr(sign * float(row[k]))
    with file.open("w", encoding="utf-8") as lines:
        csv.writer(lines).writerows([head, *rows])
    with (folder / "campaign.toml").open("a", encoding="utf-8") as lines:
        for name in sorted({row[head.index("run")] for row in rows}):
            lines.write(f'\n[[runs]]\nid = "{name}"\nexperiment = "free"\n')
    return folder


def test_a_load_in_the_wrong_direction_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(free_runs(tmp_path / "c", -1.0)), no_progress)
    assert [fault.code for fault in refused.value.faults] == [FaultCode.WRENCH_MISMATCH]


@pytest.mark.parametrize(("factor", "measures"), [(1.0, StateMeasure.DISPLACEMENT), (0.0, StateMeasure.FRAME)])
def test_what_a_free_run_measures_is_what_it_carries(factor: float, measures: StateMeasure, tmp_path: Path) -> None:
    states = reduce_campaign(load_campaign(free_runs(tmp_path / "c", factor)), no_progress).states
    assert {run.measures for run in states.runs} == {measures}
