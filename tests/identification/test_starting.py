"""A fit that starts on some states answers what one on all of them does."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.estimation.solve import ROUGH_STEP, settle
from stiffcal.estimation.unknowns import OpenBefore
from stiffcal.identification.fitting.identify import (
    SMALL_MOTION,
    Settings,
    _initial_estimate,
    fit_problem,
    identify_parameters,
)
from stiffcal.identification.fitting.load_source import LoadSource
from stiffcal.identification.readings import starting
from stiffcal.measurements.load_states import Sigma
from stiffcal.stages.experiments import robot_to_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
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


def test_the_whole_is_passed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps on all data contract as they did on a part: the next one is known to be small before it is taken."""
    truth = medium_robot()
    states = played(truth, noise=Sigma(15e-6, 2e-5), seed=3)
    monkeypatch.setattr(starting, "START_STATES", len(states) // 4)
    monkeypatch.setattr(starting, "START_RUNS", 2)
    passed: list[int] = []
    reduced = LoadSource.reduced

    def counted(self: LoadSource, *rest: Any) -> Any:
        passed.append(self.data.n_states)
        return reduced(self, *rest)

    def without_contraction(source: Any, start: Any, begun: Any, *rest: Any) -> Any:
        return settle(source, start, None if begun is None else replace(begun, contraction=1.0), *rest)

    monkeypatch.setattr(LoadSource, "reduced", counted)
    once = identify_parameters(states, truth)
    n = once.data.n_states
    assert min(passed) < n / 2
    assert passed.count(n) == 1
    passed.clear()
    monkeypatch.setattr("stiffcal.identification.fitting.identify.settle", without_contraction)
    twice = identify_parameters(states, truth)
    assert passed.count(n) == 2
    for own, other in zip(once.parameters, twice.parameters, strict=True):
        assert other.std is not None
        assert own.value == pytest.approx(other.value, abs=ROUGH_STEP * other.std)
    # what is left is that of the values that were found, not of those where the step began
    np.testing.assert_allclose(once.residual, twice.residual, rtol=0.0, atol=SMALL_MOTION * 15e-6)
