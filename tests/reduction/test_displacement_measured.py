"""Load states without a displacement are refused by every command, with what is there, what is missing, what serves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.ingest.quality.data_quality import check_load_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.set_aside import SetAsideCode
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.reduction.set_aside.displacement_measured import check_displacement_measured
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played
from tests.laboratory.small_campaign import write_small_campaign

RUNS = 4
COMMANDS = (check_campaign, ingest_campaign, identify_campaign, validate_campaign, diagnose_campaign)


@pytest.fixture(scope="module")
def states() -> LoadStates:
    return played(joint_springs(six_axes(), np.array(SIX_STIFFNESS)), runs=RUNS)


def _keep_rows(folder: Path, per_run: slice) -> Path:
    table = folder / "raw" / "states.csv"
    header, *lines = table.read_text(encoding="utf-8").splitlines()
    runs: dict[str, list[str]] = {}
    for line in lines:
        runs.setdefault(line.split(",")[0], []).append(line)
    kept = [line for own in runs.values() for line in own[per_run]]
    table.write_text("\n".join([header, *kept]) + "\n", encoding="utf-8")
    return folder


@pytest.mark.parametrize("command", COMMANDS)
def test_one_state_per_run_and_no_deflection_is_refused(command: object, tmp_path: Path) -> None:
    folder = _keep_rows(write_small_campaign(tmp_path / "one"), slice(2, 3))
    with pytest.raises(InputError) as caught:
        command(folder)  # type: ignore[operator]
    fault = caught.value.faults[0]
    assert (fault.code, fault.file, fault.place) == (FaultCode.DATA_MISSING, "campaign.toml", "runs")
    assert "4 load states in 4 runs, with joint angles, loads, places of the target" in fault.reason
    assert "every run has only one state and no deflection is given" in fault.reason
    assert "unloaded" in fault.mend
    assert not list((folder / "store").rglob("*.parquet"))


def test_rows_of_one_pose_that_are_runs_of_their_own_are_named(tmp_path: Path) -> None:
    folder = _keep_rows(write_small_campaign(tmp_path / "pairs"), slice(0, 2))
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8").replace('run = { column = "run" }', 'run = { each = "row" }')
    manifest.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        check_campaign(folder)
    assert "rows 1, 2 have the same joint angles" in caught.value.faults[0].mend
    assert "run = { column" in caught.value.faults[0].mend


def test_two_states_in_one_run_are_enough_to_go_on(states: LoadStates) -> None:
    first_of_run = np.array([np.flatnonzero(states.run == run)[0] for run in range(RUNS)])
    assert check_displacement_measured(states.select(first_of_run))
    with_second = np.sort(np.append(first_of_run, first_of_run[0] + 1))
    assert not check_displacement_measured(states.select(with_second))


def test_a_deflection_that_is_given_needs_no_second_state(states: LoadStates) -> None:
    single = states.select(np.array([np.flatnonzero(states.run == run)[1] for run in range(RUNS)]))
    assert check_displacement_measured(single)
    assert not check_displacement_measured(replace(single, deflection=np.full_like(single.deflection, 1e-4)))


def test_states_that_are_set_aside_do_not_count(states: LoadStates) -> None:
    first = np.array([np.flatnonzero(states.run == run)[:2] for run in range(RUNS)])
    pairs = states.select(first.ravel())
    aside = pairs.with_set_aside(np.arange(1, 2 * RUNS, 2), SetAsideCode.BUMPED, "bumped")
    faults = check_displacement_measured(aside)
    assert "no run has two usable states" in faults[0].reason


def test_runs_without_load_that_place_a_frame_need_no_second_state(states: LoadStates) -> None:
    single = states.select(np.array([np.flatnonzero(states.run == run)[0] for run in range(RUNS)]))
    free = tuple(replace(run, measures=StateMeasure.FRAME) for run in single.runs)
    assert not check_displacement_measured(replace(single, runs=free))


def test_while_states_are_still_to_come_nothing_is_refused(states: LoadStates, tmp_path: Path) -> None:
    campaign = load_campaign(write_small_campaign(tmp_path / "begun", poses=1))
    single = states.select(np.array([np.flatnonzero(states.run == run)[0] for run in range(RUNS)]))
    assert check_load_states(single, campaign, estimated=True)[0]
    assert not check_load_states(single, campaign, estimated=True, partial_logs=True)[0]
