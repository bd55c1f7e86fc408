"""Clamped logs of few readings: fitted like any other, or described, with the reason why they are not fitted."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.judgement.numbers import FIRM
from stiffcal.kinds.clamped.answers.parts import WITHOUT_STATES
from stiffcal.kinds.clamped.held.faults import TOO_SHORT
from tests.rates.practice_joints import JOINTS

STIFFNESS = "joint-compliance.j1.c"


def thinned(folder: Path, n: int) -> Path:
    """Return a campaign with backlash, of each log so many readings at even distances."""
    shutil.copytree(JOINTS / "02", folder, ignore=shutil.ignore_patterns("store"))
    for log in (folder / "raw").glob("*.csv.gz"):
        table = pd.read_csv(log)
        table.iloc[:: len(table) // n].to_csv(log, index=False)
    return folder


@pytest.fixture(scope="module")
def eighty_readings_a_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Such a campaign, diagnosed; not to be changed."""
    folder = thinned(tmp_path_factory.mktemp("thinned") / "c", 80)
    diagnose_campaign(folder)
    return folder


def test_eighty_readings_a_run_are_fitted_judged_and_searched(eighty_readings_a_run: Path) -> None:
    folder = eighty_readings_a_run
    assert check_campaign(folder).ready
    identified = identify_campaign(folder)
    assert identified.n_states > 6 * 70
    (compliance,) = (one for one in identified.parameters if one.name == STIFFNESS)
    assert compliance.identifiable
    judged = validate_campaign(folder)
    assert judged.scheme == "leave-one-pose-out"
    # 0.2 mrad of backlash is hidden, and the model holds none
    assert judged.rms.motor_angle == pytest.approx(0.5e-4, rel=0.2)
    found = diagnose_campaign(folder)
    # a play and a second slope at its width: one noise in all is between them
    (group,) = found.missing
    assert {group.effect, *(one.effect for one in group.alternatives)} == {"backlash", "two-slope"}
    assert group.probability is not None
    assert group.probability > FIRM
    assert not group.firm
    # runs of one programme differ by the noise of their loads alone: an exchange of two read better by chance
    assert found.suspects == []


def test_of_eighty_readings_a_run_the_play_comes_first(eighty_readings_a_run: Path) -> None:
    assert [group.effect for group in diagnose_campaign(eighty_readings_a_run).missing] == ["backlash"]


@pytest.mark.parametrize("n", [60, 75])
def test_the_interval_of_the_low_slope_holds_it_however_few_readings_there_are(n: int, tmp_path: Path) -> None:
    """The whole log says 0.109 mrad ± 0.028."""
    section: Any = identify_campaign(thinned(tmp_path / "c", n)).sections["clamped"]
    (joint,) = section.joints
    low, high = joint.low_slope_interval
    assert low < 1.1e-4 < high < 3e-4
    # b is hidden as 0.2 mrad, and a width that is not taken into the law is not excluded either
    assert joint.law_width_interval[0] < 2e-4 < joint.law_width_interval[1]


def test_of_two_dozen_readings_a_run_no_parameter_is_identified_and_why_is_said(tmp_path: Path) -> None:
    folder = thinned(tmp_path / "c", 24)
    missing = check_campaign(folder).missing
    assert len(missing) == 6
    assert all(TOO_SHORT in line for line in missing)
    identified = identify_campaign(folder)
    assert identified.n_states == 0
    assert [(one.name, one.value, one.identifiable) for one in identified.parameters] == [(STIFFNESS, None, False)]
    assert [group.reason for group in identified.not_identifiable] == [WITHOUT_STATES]
    assert sum(TOO_SHORT in warning for warning in identified.warnings) == 6
    judged = validate_campaign(folder)
    assert judged.rms.motor_angle is None
    assert WITHOUT_STATES in judged.warnings
    assert diagnose_campaign(folder).adequate is None
