"""Forms of one law are compared within one candidate; shapes that cannot be are not tried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.diagnosis.scans.candidates import list_candidates
from stiffcal.diagnosis.scans.load_scan import scan_candidates
from stiffcal.diagnosis.scans.scan import is_possible_shape
from stiffcal.effects.encoder_drift import EncoderDrift
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.viscous_power import ViscousPower
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.clamped_bench import CYCLE, clamped_bench
from tests.laboratory.effect_bench import robot_chain
from tests.laboratory.robots import six_axis_joints

CHAIN = robot_chain()
N = 2 * CYCLE.size - 1
TO_AND_FRO = 4.0 * np.sin(np.linspace(0.0, 5.0, N))


@pytest.mark.parametrize(
    ("warming", "symbol"), [(TO_AND_FRO, "rad_per_K"), (np.random.default_rng(3).normal(0.0, 2.0, N), "rad_per_s")]
)
def test_the_form_that_explains_more_is_named(warming: Floats, symbol: str) -> None:
    """A drift with the temperature, and one with time while the temperature scatters."""
    drift = np.eye(6)[2] * (2e-6 if symbol == "rad_per_K" else 3e-8)
    over = warming if symbol == "rad_per_K" else None
    states = clamped_bench(
        CHAIN, six_axis_joints(np.random.default_rng(5), 3), (2, 3), np.zeros((6, 6)), 1, 1e-6, drift, over
    )
    if over is None:
        runs = len(states) // N
        states = replace(states, temperature=np.tile(warming, runs)[:, None])
    drives = tuple(PlacedEffect(JointCompliance(), Place("joints", (k,))) for k in range(1, 7))
    fit = identify_parameters(states, CompliantRobot(CHAIN, drives, deformed=False))
    candidates, not_tried = list_candidates(fit.robot, states, {"encoder-drift": EncoderDrift()})
    assert not not_tried
    best = scan_candidates(fit, candidates).trials[0]
    assert best.candidate.name == "encoder-drift j3"
    assert [spec.symbol for spec in best.candidate.effect.parameters] == [symbol]
    assert best.regressor.symbols == (symbol,)
    assert best.n_variants == 2


def test_a_power_near_one_is_not_tried() -> None:
    assert is_possible_shape(ViscousPower(), {"power": 0.8})
    assert not is_possible_shape(ViscousPower(), {"power": 0.96})
