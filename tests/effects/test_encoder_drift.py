"""encoder-drift: readings of clamped motors that wander with time or temperature."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.effects.encoder_drift import EncoderDrift
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.effect import Effect, Place
from stiffcal.model.forms import added_forms, form_of
from tests.laboratory.clamped_bench import CYCLE, clamped_bench, model_with
from tests.laboratory.effect_bench import bare_states, robot_chain
from tests.laboratory.robots import six_axis_joints

EFFECT, CHAIN = EncoderDrift(), robot_chain()
JOINT = 3
PLACE = Place("joints", (JOINT,))
POSES = six_axis_joints(np.random.default_rng(5), 2)
N = 2 * CYCLE.size - 1
RATE = np.eye(6)[JOINT - 1]
RIGID = np.zeros((6, 6))
# Up and down again, so that it does not follow time.
WARMING = 4.0 * np.sin(np.linspace(0.0, 5.0, N))


@pytest.mark.parametrize(
    ("symbol", "rate", "warming"), [("rad_per_s", 3e-8, None), ("rad_per_s", -3e-8, None), ("rad_per_K", 2e-6, WARMING)]
)
def test_a_bench_with_a_drifting_encoder_gives_it_back(symbol: str, rate: float, warming: None) -> None:
    states = clamped_bench(CHAIN, POSES, (2, 3), RIGID, noise=1e-6, drift=rate * RATE, warming=warming)
    assert EFFECT.lacking(CHAIN, states) is None
    model = model_with(CHAIN, form_of(EFFECT, [symbol]), PLACE, JointCompliance())
    parameter = identify_parameters(states, model).parameter(f"encoder-drift.j{JOINT}.{symbol}")
    assert parameter.value is not None
    assert parameter.std is not None
    assert parameter.std < 0.2 * abs(rate)
    assert abs(parameter.value - rate) < 4.0 * parameter.std


def test_columns_are_the_slopes_of_the_prediction() -> None:
    data = observe(clamped_bench(CHAIN, POSES, (2,), RIGID, noise=0.0), CHAIN)
    drives = {f"joint-compliance.j{k}.c": 1e-6 for k in range(1, 7)}
    name = f"encoder-drift.j{JOINT}.rad_per_s"
    robot = model_with(CHAIN, EFFECT, PLACE, JointCompliance()).with_values(drives | {name: 1e-8})
    free = [column for column in free_columns(robot) if column.placed == 6]
    (column,) = np.concatenate([block.columns for block in evaluate(robot, data, free)], axis=2)
    ends = [predict_observations(robot.with_values({name: value}), data) for value in (0.0, 2e-8)]
    slope = (ends[1] - ends[0]) / 2e-8
    np.testing.assert_allclose(column, slope, atol=1e-6 * np.abs(slope).max())
    # A reading that runs ahead is taken for motion that the drive did not give.
    row = data.rows_of(int(data.kind.max()))[JOINT - 1]
    assert slope[row, -1] == pytest.approx(-data.order.since_reference[-1], rel=1e-6)


def test_forms_by_symbol_and_by_data() -> None:
    over_temperature = form_of(EFFECT, ["rad_per_K"])
    assert [spec.symbol for spec in over_temperature.parameters] == ["rad_per_K"]
    assert form_of(EFFECT, ["rad_per_s"]) is EFFECT
    assert [spec.symbol for spec in form_of(over_temperature, ["rad_per_s"]).parameters] == ["rad_per_s"]
    timed, warmed = (clamped_bench(CHAIN, POSES[:1], (2,), RIGID, warming=warming) for warming in (None, WARMING))

    def forms(states: LoadStates) -> list[Effect]:
        return [form for form in added_forms(EFFECT) if form.lacking(CHAIN, states) is None]

    assert [form.parameters[0].symbol for form in forms(timed)] == ["rad_per_s"]
    assert [form.parameters[0].symbol for form in forms(warmed)] == ["rad_per_s", "rad_per_K"]


def test_what_is_missing_is_named() -> None:
    assert "clamped runs" in str(EFFECT.lacking(CHAIN, bare_states([0, 0, 0])))
