"""Forecasts of readings of every kind: one linear step is near the refit, whatever was measured."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.live.choice import ModelChoice
from stiffcal.live.models import LiveModels
from stiffcal.stages.steps import RunContext
from stiffcal.view.content import ViewModel
from tests.laboratory.kr125 import simulated

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
TWO_DRIVES = 'schema = "stiffcal/model/1"\n\n[[effects]]\ntype = "joint-compliance"\njoints = [4, 6]\n'


def _forecast_and_refit(models: LiveModels, choice: ModelChoice) -> tuple[ViewModel, ViewModel]:
    forecast = models.forecast(choice)
    assert forecast is not None
    (expected,) = forecast.models
    assert expected is not None
    refit = next(model for model in models.content(choice).models if model.present)
    assert expected.residual_heldout is not None
    assert refit.residual_heldout is not None
    known = np.isfinite(refit.residual_heldout)
    assert np.array_equal(np.isfinite(expected.residual_heldout), known)
    return expected, refit


def test_torque_over_motion(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(CAMPAIGNS / "joints" / "07", tmp_path / "07"))
    models = LiveModels(folder, RunContext())
    assert models.prepare()
    for name in ("stribeck j1", "viscous-power j1"):
        forecast, refit = _forecast_and_refit(models, ModelChoice(added=[name]))
        assert forecast.heldout_rms is not None
        assert refit.heldout_rms is not None
        # one linear step in the shape that is best with all speeds: second order in what a fit without one changes
        assert forecast.heldout_rms.torque == pytest.approx(refit.heldout_rms.torque, rel=0.05)


@pytest.mark.long
def test_clamped_runs_of_two_drives(tmp_path: Path) -> None:
    folder = simulated(tmp_path / "two", ("a-joint4", "b-joint4", "a-joint6", "b-joint6"))
    (folder / "model.toml").write_text(TWO_DRIVES, encoding="utf-8")
    models = LiveModels(folder, RunContext())
    assert models.prepare()
    forecast, refit = _forecast_and_refit(models, ModelChoice(added=["backlash j4", "cubic-stiffness j6"]))
    assert forecast.heldout_rms is not None
    assert refit.heldout_rms is not None
    assert forecast.heldout_rms.motor_angle == pytest.approx(refit.heldout_rms.motor_angle, rel=0.05)
