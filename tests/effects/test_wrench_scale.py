"""wrench-scale: force read = [force] × true, moment read = [force] × [moment] × true; 1 is right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.backlash import Backlash
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.wrench_scale import WrenchScale
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, Inputs, Place
from tests.laboratory.effect_bench import bare_states, robot_chain, settled
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axis_joints

EFFECT = WrenchScale()
PLACE = Place("setup")
CHAIN = robot_chain()
SPRINGS = [(JointCompliance(), Place("joints", (k,)), {"c": 1.0 / float(SIX_STIFFNESS[k - 1])}) for k in range(1, 7)]
PLAY = (Backlash(), Place("joints", (2,)), {"width": 2e-4, "band": 40.0})
QUIET = Noise(1e-9, 1e-9, 0.0, 0.0, "manifest", np.inf)


def test_readings_are_divided_by_the_gains() -> None:
    rng = np.random.default_rng(19)
    joints, true = CHAIN.model_angles(rng.uniform(-1, 1, (4, 6))), rng.normal(0.0, 100.0, (4, 6))
    read = true * np.repeat([1.03, 1.03 * 0.98], 3)
    found = settled([*SPRINGS, (EFFECT, PLACE, {"moment": 0.98, "force": 1.03})], joints, read).displacement
    np.testing.assert_allclose(found, settled(SPRINGS, joints, true).displacement, atol=1e-14)


def test_one_changes_nothing_and_weight_is_not_read() -> None:
    inputs = Inputs(np.zeros((6, 1)), np.ones((6, 1)), force_sensor_setup(CHAIN))
    assert EFFECT.adjusted(PLACE, inputs, {"moment": 1.0}) is inputs
    unread = replace(inputs, loaded=False)
    assert EFFECT.adjusted(PLACE, unread, {"moment": 1.5}) is unread


def test_forces_alone_are_redundant_with_the_compliances() -> None:
    setup = replace(force_sensor_setup(CHAIN), moments_measured=False)
    assert "redundant with all compliances" in str(EFFECT.lacking(CHAIN, bare_states([0], setup=setup)))


def fitted(truth: Sequence[tuple[Effect, Place, dict[str, float]]], fixed: frozenset[str] = frozenset()) -> Fit:
    """Return the fit to exact displacements of a robot whose sensor reads 3 % too much, moments another 2 % less."""
    rng = np.random.default_rng(20)
    run = np.repeat(np.arange(8), 13)
    true = np.zeros((len(run), 6))
    direction = rng.normal(size=(8, 3, 6)) * np.repeat([400.0, 60.0], 3)
    level = np.array([0.3, 0.7, 1.0, -1.0])
    for pose in range(8):
        true[run == pose] = np.concatenate(
            [np.zeros((1, 6)), (direction[pose][:, None] * level[None, :, None]).reshape(-1, 6)]
        )
    joints = six_axis_joints(rng, 8)[run]
    setup = force_sensor_setup(CHAIN)
    balance = settled(truth, CHAIN.model_angles(joints), true)
    states = bare_states(
        run.tolist(), joints, setup, wrench=true * np.repeat([1.03, 1.03 * 0.98], 3),
        position=balance.target_position,
        rotation=np.einsum(
            "nbij,nbjk->nbik",
            rotation_from_vector(balance.displacement[:, 0, 3:])[:, None], balance.unloaded_rotation,
        ),
    )  # fmt: skip
    model = CompliantRobot(CHAIN, tuple(PlacedEffect(e, p) for e, p, _ in (*truth, (EFFECT, PLACE, {}))))
    return identify_parameters(states, model, Settings(noise=QUIET, fixed=fixed))


def test_the_gain_of_forces_is_not_determined_and_the_answer_says_why() -> None:
    fit = fitted(SPRINGS)
    assert not fit.parameter("wrench-scale.setup.force").identifiable
    assert fit.parameter("wrench-scale.setup.moment").value == pytest.approx(0.98, abs=1e-4)
    (cause,) = (a.cause for a in fit.ambiguities if "wrench-scale.setup.force" in a.names)
    assert cause is Undetermined.GAIN_OF_LOAD
    for k, stiffness in enumerate(SIX_STIFFNESS, start=1):
        compliance = fit.parameter(f"joint-compliance.j{k}.c").value
        assert compliance == pytest.approx(1.0 / stiffness / 1.03, rel=2e-3)


def test_play_that_weight_and_load_cross_determines_it() -> None:
    fit = fitted([*SPRINGS, PLAY])
    assert fit.parameter("wrench-scale.setup.force").value == pytest.approx(1.03, abs=2e-3)
    assert fit.parameter("joint-compliance.j1.c").value == pytest.approx(1.0 / SIX_STIFFNESS[0], rel=2e-3)
