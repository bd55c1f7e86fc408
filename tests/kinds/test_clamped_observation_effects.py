"""Clamped runs that are simulated with a fixture that gives, and with an encoder that drifts."""

from __future__ import annotations

import numpy as np

from stiffcal.kinds.clamped.simulated.simulation import simulate_clamped, sweep_program
from stiffcal.kinds.clamped.simulated.simulation_settings import Clamping
from stiffcal.measurements.load_states import Attachment
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from stiffcal.model.forms import form_of
from stiffcal.simulation.played.motion import MotionProgram
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight
from stiffcal.simulation.settings import Loads
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

EFFECTS, CHAIN = built_in_effects(), six_axes()
POSE = np.radians([10.0, -60.0, 50.0, 20.0, 40.0, 10.0])
FLANGE = Attachment(7, np.eye(4))
FIXTURE = np.diag([3e-7] * 3 + [2e-6] * 3)
DRIVES = tuple(
    PlacedEffect(EFFECTS["joint-compliance"], Place("joints", (k + 1,)), {"c": 1.0 / float(SIX_STIFFNESS[k])})
    for k in range(6)
)


def played(fixture: np.ndarray, *placed: PlacedEffect) -> MotionProgram:
    program = sweep_program(Clamping(amplitude_deg=0.05, points=12, cycles=1), POSE, 3)
    planned = PlannedRun("a", POSE, program, Loads(), FLANGE, 3600.0, warming_K_per_hour=2.0)
    robot = CompliantRobot(CHAIN, (*DRIVES, *placed))
    done = simulate_clamped(robot, planned, {}, ToolWeight(0.0, np.zeros(3)), fixture).planned.program
    assert isinstance(done, MotionProgram)
    return done


def test_a_fixture_of_the_model_gives_like_one_of_the_settings() -> None:
    gives = PlacedEffect(EFFECTS["fixture-compliance"], Place("setup"), {"translation": 3e-7, "rotation": 2e-6})
    rigid = np.zeros((6, 6))
    by_model, by_settings, without = (played(rigid, gives), played(FIXTURE), played(rigid))
    np.testing.assert_allclose(by_model.wrench_at_node, by_settings.wrench_at_node, rtol=1e-9, atol=1e-9)
    assert np.abs(without.wrench_at_node).max() > 1.05 * np.abs(by_model.wrench_at_node).max()


def test_readings_of_a_drifting_encoder_run_ahead() -> None:
    drift = EFFECTS["encoder-drift"]
    rigid = np.zeros((6, 6))
    without = played(rigid)
    in_time = played(rigid, PlacedEffect(drift, Place("joints", (5,)), {"rad_per_s": 1e-6}))
    warming = PlacedEffect(form_of(drift, ["rad_per_K"]), Place("joints", (2,)), {"rad_per_K": 1e-3})
    by_temperature = played(rigid, warming)
    wanted = np.zeros_like(without.joints)
    wanted[:, 4] = 1e-6 * without.node
    np.testing.assert_allclose(in_time.joints - without.joints, wanted, atol=1e-12)
    wanted = np.zeros_like(without.joints)
    wanted[:, 1] = 1e-3 * 2.0 * without.node / 3600.0
    np.testing.assert_allclose(by_temperature.joints - without.joints, wanted, atol=1e-12)
    np.testing.assert_array_equal(in_time.wrench_at_node, without.wrench_at_node)


def test_effects_of_other_runs_do_not_touch_it() -> None:
    slip = PlacedEffect(EFFECTS["seat-shift"], Place("setup"), {"state": 3.0, "x": 1e-3, "y": 0.0, "z": 0.0})
    with_slip, without = (played(np.zeros((6, 6)), slip), played(np.zeros((6, 6))))
    np.testing.assert_allclose(with_slip.wrench_at_node, without.wrench_at_node, rtol=1e-12)
