"""clock-offset: y_seen(t) = y(t + offset); in sweeps, where the load moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.clock_offset import ClockOffset
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates, RunInfo
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.effect_bench import bare_states, robot_chain
from tests.laboratory.robots import SIX_STIFFNESS, six_axis_joints

EFFECT = ClockOffset()
LATE = 0.08


def test_a_ramp_is_found_ahead() -> None:
    time = np.linspace(0.0, 10.0, 101)
    seen = EFFECT.measured_at(time, 3.0 * time, 0.25)
    np.testing.assert_allclose(seen[:90] - 3.0 * time[:90], 0.75)
    np.testing.assert_array_equal(EFFECT.measured_at(time, 3.0 * time, 0.0), 3.0 * time)


def test_load_states_that_are_held_show_no_motion() -> None:
    assert "sweeps or ramps" in str(EFFECT.lacking(robot_chain(), bare_states([0, 0, 0])))


def springs() -> CompliantRobot:
    drive = built_in_effects()["joint-compliance"]
    placed = [PlacedEffect(drive, Place("joints", (k + 1,)), {"c": 1.0 / float(SIX_STIFFNESS[k])}) for k in range(6)]
    return CompliantRobot(robot_chain(), tuple(placed))


def swept_states(late: float) -> LoadStates:
    """Eight poses, each swept up and down at two speeds; positions read `late` after the force."""
    rng = np.random.default_rng(8)
    poses = six_axis_joints(rng, 8)
    level = np.concatenate([[0.0], np.linspace(0.1, 1.0, 10), np.linspace(0.9, 0.1, 9), [0.0]])
    robot, chain = springs(), robot_chain()
    run, joints, wrench, time, later = [], [], [], [], []
    for k, pose in enumerate(poses):
        direction = rng.normal(size=6) * np.repeat([400.0, 60.0], 3)
        stamp = np.cumsum(np.concatenate([[0.0, 3.0], np.full(18, 0.4 if k % 2 else 1.6), [3.0]]))
        # in the rests at both ends nothing moves
        ahead = np.interp(stamp + late, stamp[1:-1], level[1:-1])
        ahead[[0, -1]] = 0.0
        run += [k] * level.size
        joints.append(np.tile(pose, (level.size, 1)))
        wrench.append(level[:, None] * direction)
        later.append(ahead[:, None] * direction)
        time.append(stamp + 100.0 * k)
    states = bare_states(run, np.concatenate(joints), wrench=np.concatenate(wrench), time=np.concatenate(time))
    states = replace(states, runs=tuple(RunInfo(info.name, swept=True) for info in states.runs))
    balance = solve_balance(robot, chain.model_angles(states.joints), np.concatenate(later), states.setup)
    position = balance.target_position + 2e-6 * rng.normal(size=balance.target_position.shape)
    return replace(states, position=position)


@pytest.mark.parametrize("late", [LATE, -0.05, 0.0])
def test_it_is_found_in_sweeps(late: float) -> None:
    states = swept_states(late)
    assert EFFECT.lacking(robot_chain(), states) is None
    unvalued = tuple(PlacedEffect(one.effect, one.place) for one in springs().placed)
    model = CompliantRobot(robot_chain(), (*unvalued, PlacedEffect(EFFECT, Place("setup"))))
    offset = identify_parameters(states, model).parameter("clock-offset.setup.offset")
    assert offset.value is not None
    assert offset.std is not None
    # where a sweep turns, a straight slope through the states before and after cuts the corner
    assert offset.value == pytest.approx(late, abs=0.1 * abs(late) + 4.0 * offset.std)
    assert offset.std < 0.01
