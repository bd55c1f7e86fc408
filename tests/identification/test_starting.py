"""A fit that starts on some states answers what one on all of them does."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.estimation.unknowns import OpenBefore
from stiffcal.identification import starting
from stiffcal.identification.identify import Settings, _initial_estimate, fit_problem, identify_parameters
from stiffcal.workflow.experiments import robot_to_fit
from stiffcal.workflow.steps import RunContext, up_to_date_states
from tests.laboratory.simulated_states import medium_robot, played
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


def test_values_of_the_model_file_do_not_count_twice() -> None:
    """The first fit is the step from them: what they predict is in the residual no more, held ones included."""
    truth = medium_robot()
    problem, settings = fit_problem(played(truth), truth), Settings()
    bare = replace(truth, placed=tuple(replace(placed, values={}) for placed in truth.placed))
    held = frozenset({truth.placed[1].parameter_name("c")})
    for robot, fixed in ((bare, frozenset()), (truth, frozenset()), (truth, held)):
        start = _initial_estimate(problem, robot, replace(settings, fixed=fixed), OpenBefore())
        for found, placed in zip(start.placed, truth.placed, strict=True):
            # the deformed chain differs from the one as drawn by a per cent
            assert found.amplitude("c") == pytest.approx(placed.amplitude("c"), rel=0.1)
