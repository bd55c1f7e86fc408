"""A clamped run whose torque over angle no law describes: the description leaves it out, the fit does not."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.clamped.answers import analysis, parts
from stiffcal.kinds.clamped.answers.results import ClampedSection
from stiffcal.kinds.clamped.loops.branches import Branches
from stiffcal.kinds.clamped.loops.torque_angle_fit import SeriesFit, fit_series
from tests.rates.practice_joints import JOINTS

REASON = "an opaque reason"


def make_first_fail(monkeypatch: pytest.MonkeyPatch, code: FaultCode) -> None:
    """Have the description of the first run end with a fault; nothing that is computed outlives the test."""
    calls: list[Branches] = []

    def fit(data: Branches, *, with_lag: bool = False) -> SeriesFit:
        calls.append(data)
        if len(calls) == 1:
            raise InputError.at(code, "campaign.toml", "runs", REASON, "mend")
        return fit_series(data, with_lag=with_lag)

    monkeypatch.setattr(analysis, "fit_series", fit)
    monkeypatch.setattr(parts, "_LAST", {})


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    return Path(shutil.copytree(JOINTS / "01", tmp_path / "c"))


def test_a_run_whose_curve_does_not_settle_is_left_out_with_its_reason(
    campaign: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The parameters come from the run's states all the same."""
    make_first_fail(monkeypatch, FaultCode.NO_CONVERGENCE)
    answer = identify_campaign(campaign)
    section = answer.sections["clamped"]
    assert isinstance(section, ClampedSection)
    assert [run.left_out for run in section.runs] == [REASON, *[""] * 5]
    assert [[run.why for run in joint.left_out] for joint in section.joints] == [[REASON]]
    assert answer.n_runs == 6
    assert [parameter.identifiable for parameter in answer.parameters] == [True]
    assert sum(REASON in warning for warning in answer.warnings) == 1


def test_other_faults_of_a_description_are_faults(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_first_fail(monkeypatch, FaultCode.POSE_UNREACHABLE)
    with pytest.raises(InputError) as caught:
        identify_campaign(campaign)
    assert caught.value.code is FaultCode.POSE_UNREACHABLE
