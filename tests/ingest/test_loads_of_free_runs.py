"""A run that was to be unloaded, and carries a load next to those of load runs, is checked as a load run is."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.reduction.states.load_states import _loaded_all_the_same
from tests.laboratory.small_campaign import write_small_campaign

FORCES = ("Fx", "Fy", "Fz")
NOISE_N = 0.3
POSES = ("pose1", "pose2", "pose3", "pose4")
LOADED, FREE, HELD = StateMeasure.DISPLACEMENT, StateMeasure.FRAME, StateMeasure.MOTOR_ANGLE
Forces = Callable[[Floats], Floats]


def campaign_of(folder: Path, forces: Mapping[str, Forces], *entries: str) -> Path:
    """Write the small campaign with the forces of some runs changed, and with entries of runs in the manifest."""
    write_small_campaign(folder)
    file = folder / "raw" / "states.csv"
    with file.open(encoding="utf-8") as lines:
        head, *rows = csv.reader(lines)
    columns = [head.index(name) for name in FORCES]
    for row in rows:
        changed = forces.get(row[head.index("run")])
        if changed is not None:
            for k, force in zip(columns, changed(np.array([float(row[k]) for k in columns])), strict=True):
                row[k] = repr(float(force))
    with file.open("w", encoding="utf-8") as lines:
        csv.writer(lines).writerows([head, *rows])
    with (folder / "campaign.toml").open("a", encoding="utf-8") as lines:
        lines.writelines(f"\n[[runs]]\n{entry}\n" for entry in entries)
    return folder


def entry(name: str, experiment: str, *more: str) -> str:
    return "\n".join([f'id = "{name}"', f'experiment = "{experiment}"', *more])


def times(factor: float) -> Forces:
    return lambda force: factor * force


def noise(seed: int) -> Forces:
    rng = np.random.default_rng(seed)
    return lambda force: NOISE_N * rng.standard_normal(3)


def measured_in(folder: Path) -> list[StateMeasure | None]:
    return [run.measures for run in reduce_campaign(load_campaign(folder), no_progress).states.runs]


def test_a_load_in_the_wrong_direction_is_refused(tmp_path: Path) -> None:
    runs = [entry("pose1", "load"), *(entry(name, "free") for name in POSES[1:])]
    folder = campaign_of(tmp_path / "c", dict.fromkeys(POSES[1:], times(-1.0)), *runs)
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(folder), no_progress)
    assert [fault.code for fault in refused.value.faults] == [FaultCode.WRENCH_MISMATCH]


@pytest.mark.parametrize(("forces", "measures"), [(times(1.0), LOADED), (times(0.0), FREE), (noise(1), FREE)])
def test_what_a_free_run_measures_is_what_it_carries(forces: Forces, measures: StateMeasure, tmp_path: Path) -> None:
    runs = [entry("pose1", "load"), *(entry(name, "free") for name in POSES[1:])]
    folder = campaign_of(tmp_path / "c", dict.fromkeys(POSES[1:], forces), *runs)
    assert measured_in(folder) == [LOADED, *[measures] * 3]


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_the_sensor_is_no_load_where_all_runs_are_free(seed: int, tmp_path: Path) -> None:
    runs = [entry(name, "free") for name in POSES]
    assert measured_in(campaign_of(tmp_path / "c", dict.fromkeys(POSES, noise(seed)), *runs)) == [FREE] * 4


def test_nor_where_the_others_are_clamped(tmp_path: Path) -> None:
    runs = [entry("pose1", "clamped", "moved_joint = 1"), *(entry(name, "free") for name in POSES[1:])]
    folder = campaign_of(tmp_path / "c", dict.fromkeys(POSES[1:], noise(0)), *runs)
    assert measured_in(folder) == [HELD, *[FREE] * 3]


@pytest.mark.parametrize("run", [0, 1], ids=["of a load run", "of the free run"])
def test_a_load_that_is_no_number_leaves_the_others_compared(run: int, tmp_path: Path) -> None:
    states = reduce_campaign(load_campaign(campaign_of(tmp_path / "c", {})), no_progress).states
    runs = tuple(replace(info, measures=FREE if k == 1 else LOADED) for k, info in enumerate(states.runs))
    wrench = states.wrench.copy()
    wrench[np.flatnonzero(states.run == run)[1]] = np.nan
    found = _loaded_all_the_same(replace(states, runs=runs, wrench=wrench))
    assert [info.measures for info in found.runs] == [LOADED] * 4
