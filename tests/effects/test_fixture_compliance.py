"""fixture-compliance: J (Δd_motor + δ) = −C W."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.effects.fixture_compliance import FixtureCompliance
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Place
from tests.laboratory.clamped_bench import clamped_bench, model_with
from tests.laboratory.effect_bench import bare_states, robot_chain
from tests.laboratory.robots import SIX_STIFFNESS, chain_from_rows, shifted, six_axis_joints

EFFECT, CHAIN = FixtureCompliance(), robot_chain()
SETUP = Place("setup")
TRANSLATION, ROTATION = 4e-8, 4e-7
FIXTURE = np.diag([TRANSLATION] * 3 + [ROTATION] * 3)
POSES = six_axis_joints(np.random.default_rng(5), 3)


def valued(translation: float = TRANSLATION, rotation: float = ROTATION) -> CompliantRobot:
    """Return the true drives with a fixture."""
    robot = model_with(CHAIN, EFFECT, SETUP, JointCompliance())
    drives = {f"joint-compliance.j{k + 1}.c": 1.0 / float(SIX_STIFFNESS[k]) for k in range(6)}
    fixture = {f"fixture-compliance.setup.{s}": v for s, v in (("translation", translation), ("rotation", rotation))}
    return robot.with_values(drives | fixture)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_bench_with_a_soft_fixture_gives_it_back(seed: int) -> None:
    """From a simulation of the closed chain that shares no code with the fit, with readings of 2 µrad noise."""
    states = clamped_bench(CHAIN, POSES, (1, 2, 3, 5), FIXTURE, seed)
    assert EFFECT.lacking(CHAIN, states) is None
    fit = identify_parameters(states, model_with(CHAIN, EFFECT, SETUP, JointCompliance()))
    for symbol, truth in (("translation", TRANSLATION), ("rotation", ROTATION)):
        parameter = fit.parameter(f"fixture-compliance.setup.{symbol}")
        assert parameter.value is not None
        assert parameter.std is not None
        assert parameter.std < 0.1 * truth
        assert abs(parameter.value - truth) < 4.0 * parameter.std + 0.01 * truth


def test_columns_are_the_slopes_of_the_prediction() -> None:
    data = observe(clamped_bench(CHAIN, POSES[:2], (2, 5), FIXTURE, noise=0.0), CHAIN)
    robot = valued()
    free = [column for column in free_columns(robot) if robot.placed[column.placed].effect is EFFECT]
    columns = np.concatenate([block.columns for block in evaluate(robot, data, free)], axis=2)
    assert [column.symbol for column in free] == ["translation", "rotation"]
    for column, ends in zip(
        columns, [(valued(2e-8), valued(6e-8)), (valued(rotation=2e-7), valued(rotation=6e-7))], strict=True
    ):
        step = 4e-8 if ends[0].placed[-1].values["translation"] == 2e-8 else 4e-7
        slope = (predict_observations(ends[1], data) - predict_observations(ends[0], data)) / step
        np.testing.assert_allclose(column, slope, atol=1e-6 * np.abs(slope).max())
        assert np.abs(slope).max() > 0.0


def test_one_joint_that_always_loads_it_alike_is_joint_compliance_again() -> None:
    """One joint in one pose; a flange on a single axis, whatever its angle."""
    again = "separated from joint-compliance"
    assert again in str(EFFECT.lacking(CHAIN, clamped_bench(CHAIN, POSES[:1], (2,), FIXTURE)))
    assert EFFECT.lacking(CHAIN, clamped_bench(CHAIN, POSES[:1], (2, 5), FIXTURE)) is None
    assert EFFECT.lacking(CHAIN, clamped_bench(CHAIN, POSES[:2], (2,), FIXTURE)) is None
    axis = chain_from_rows("axis", ((0.0, 0.0, 0.2, 0.0, 5.0, (0.0, 0.0, 0.0)),), shifted(0.3, 0.0, 0.1))
    positions = clamped_bench(axis, np.array([[0.1], [0.8], [2.0]]), (1,), FIXTURE)
    assert again in str(EFFECT.lacking(axis, positions))
    assert "clamped runs" in str(EFFECT.lacking(CHAIN, bare_states([0, 0, 0])))


def test_states_that_were_not_clamped_do_not_show_it() -> None:
    data = observe(bare_states([0, 0, 0], rotation=np.tile(np.eye(3), (3, 1, 1, 1))), CHAIN)
    free = [column for column in free_columns(valued()) if column.placed == 6]
    assert not any(block.columns.any() for block in evaluate(valued(), data, free))
