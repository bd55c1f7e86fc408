"""wrench-bias: true wrench = reading − bias − weight of a mass at the sensor's origin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.wrench_bias import WrenchBias
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.model.effect import Inputs, Place
from tests.laboratory.effect_bench import bare_states, robot_chain, settled
from tests.laboratory.robots import force_sensor_setup

EFFECT = WrenchBias()
PLACE = Place("setup")
CHAIN = robot_chain()
SPRINGS = [(JointCompliance(), Place("joints", (k,)), {"c": 1e-9}) for k in range(1, 7)]


def test_bias_is_subtracted_from_the_reading() -> None:
    rng = np.random.default_rng(15)
    joints, wrench = CHAIN.model_angles(rng.uniform(-1, 1, (4, 6))), rng.normal(0.0, 50.0, (4, 6))
    bias = {"fx": 3.0, "fy": -2.0, "fz": 1.0, "mx": 0.5, "my": -0.4, "mz": 0.3}
    found = settled([*SPRINGS, (EFFECT, PLACE, bias)], joints, wrench).displacement
    plain = settled(SPRINGS, joints, wrench - list(bias.values())).displacement
    np.testing.assert_allclose(found, plain, atol=1e-14)


@pytest.mark.parametrize("tool_mass", [0.0, 7.0, 20.0])
def test_weight_that_was_read_is_subtracted(tool_mass: float) -> None:
    """On a nearly rigid robot the weight's direction is the rigid chain's; a net tool mass of zero works as well."""
    rng = np.random.default_rng(16)
    joints, wrench = CHAIN.model_angles(rng.uniform(-1, 1, (4, 6))), rng.normal(0.0, 50.0, (4, 6))
    setup = force_sensor_setup(CHAIN, tool_mass, (0.02, 0.01, 0.1))
    found = settled([*SPRINGS, (EFFECT, PLACE, {"mass": 7.0})], joints, wrench, setup).displacement
    _, rotation = attached_poses(CHAIN, joints, setup.wrench_axes)
    weight = np.einsum("nji,j->ni", rotation, 7.0 * CHAIN.gravity)
    true = wrench.copy()
    true[:, :3] -= weight
    np.testing.assert_allclose(found, settled(SPRINGS, joints, true, setup).displacement, atol=1e-11)


def test_no_reading_in_the_weight_only_state() -> None:
    inputs = Inputs(np.zeros((6, 1)), np.zeros((6, 1)), force_sensor_setup(CHAIN), loaded=False)
    assert EFFECT.adjusted(PLACE, inputs, {"fx": 3.0, "mass": 2.0}) is inputs


def test_where_it_can_be_found() -> None:
    still = bare_states([0, 0, 1, 1])
    assert "several orientations" in str(EFFECT.lacking(CHAIN, still))
    joints = still.joints.copy()
    joints[1, 4] = 0.5
    assert EFFECT.lacking(CHAIN, replace(still, joints=joints)) is None
    assert EFFECT.lacking(CHAIN, replace(still, deflection=np.zeros((4, 1, 6)))) is None
    places = replace(still, runs=tuple(replace(run, measures=StateMeasure.PLACE) for run in still.runs))
    assert "load runs" in str(EFFECT.lacking(CHAIN, places))
