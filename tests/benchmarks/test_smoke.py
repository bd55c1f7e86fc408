"""The benchmarks still run, in small; what they measure counts only by hand (``make bench``)."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks import clamped_coverage, compensation_coverage, coverage, fit_speed, step_speed
from tests.benchmarks.__main__ import SMOKE, main
from tests.laboratory.hidden_arrays import scatter_within_runs
from tests.laboratory.mujoco_robot import MujocoRobot
from tests.laboratory.mujoco_states import NOISE, Plan, simulate_campaign
from tests.laboratory.practice_marks import with_practice


# What large campaigns cost begins with whole campaigns: `make practice` tries these.
@pytest.mark.parametrize(
    "name", with_practice(SMOKE, *(SMOKE.keys() - {"cost", "judgement_cost", "plan_cost", "absolute_cost"}))
)
def test_every_benchmark_runs(name: str) -> None:
    assert main(["--smoke", "--only", name]) == 0


def test_a_benchmark_that_raises_did_not_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SMOKE, "jacobian_speed", ("no number",))
    assert main(["--smoke", "--only", "jacobian_speed"]) == 2


def test_coverage_prints_its_table(capsys: pytest.CaptureFixture[str]) -> None:
    coverage.main(["--campaigns", "4", "--poses", "6"])
    printed = capsys.readouterr().out
    assert "4 campaigns, 24 parameters" in printed
    assert all(name in printed for name in coverage.PLANS)


def test_coverage_of_clamped_joints_plays_each_run_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clamped_coverage, "POINTS", 60)
    clamped_coverage.main(["--seeds", "1"])
    assert "18 coefficients of 1 campaigns" in capsys.readouterr().out


def test_a_path_is_corrected_by_what_was_identified() -> None:
    plan, tilted = compensation_coverage.PLANS["drives and bearings 1 to 3, position"]
    found = compensation_coverage.judge(plan, tilted, 7, 4)
    assert found.gone > 0.95
    assert found.inside.shape == found.chi2.shape == (4,)


def test_simulated_readings_scatter_by_the_noise_they_state() -> None:
    """With the truth through MuJoCo again, what is left is the tracker's noise and the wrench noise carried through."""
    campaign = simulate_campaign(np.random.default_rng(4), Plan(full_pose=False))
    states = campaign.states
    robot = MujocoRobot(campaign.chain, 1.0 / campaign.joint_compliance, states.setup)
    at = robot.settle(campaign.chain.model_angles(states.joints), states.wrench).position[:, 0]
    left = scatter_within_runs(states.position[:, 0] - at, states.run.astype(np.float64))
    assert NOISE.translation is not None
    assert 0.95 < left / NOISE.translation < 1.15


def test_states_of_the_speed_benchmark_are_full_poses() -> None:
    states = fit_speed.many_states(300)
    assert len(states) == 300
    assert states.has_orientation
    assert int(states.reference.sum()) == len(states.runs) == 3


def test_the_step_function_is_quick() -> None:
    """By the time of its own thread: half of the calls within what is asked for, several times what they take.

    Wall time on a shared machine is the others' too; ``make bench`` judges that.
    """
    _, own = step_speed.step_times(1000)
    assert np.median(own) < step_speed.MEDIAN_US
