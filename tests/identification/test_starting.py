"""A fit that starts on some states answers what one on all of them does."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.identification import starting
from stiffcal.identification.identify import identify_parameters
from stiffcal.workflow.experiments import robot_to_fit
from stiffcal.workflow.steps import RunContext, up_to_date_states
from tests.rates.practice_joints import JOINTS


def test_thinned_sweeps_only_start_the_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = Path(shutil.copytree(JOINTS / "02", tmp_path / "02", ignore=shutil.ignore_patterns("store")))
    data = up_to_date_states(folder, RunContext())
    states, robot = data.states, robot_to_fit(data)
    assert len(states) < 2 * starting.START_SWEPT
    whole = identify_parameters(states, robot)
    monkeypatch.setattr(starting, "START_SWEPT", len(states) // 4)
    started = identify_parameters(states, robot)
    chosen = starting.starting_states(started.data)
    assert chosen is not None
    assert np.count_nonzero(chosen) < len(states) / 3
    assert started.data.n_states == whole.data.n_states
    assert started.last_step is None
    for own, other in zip(started.parameters, whole.parameters, strict=True):
        assert other.std is not None
        # a step below a hundredth of the uncertainty ends the fit
        assert own.value == pytest.approx(other.value, abs=0.05 * other.std)
        assert own.std == pytest.approx(other.std, rel=0.01)
