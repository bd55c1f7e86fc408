"""Effects of moving joints are found in simulated logs, and nothing where there is nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.diagnosis.row_context import RowSearchContext
from stiffcal.diagnosis.row_document import RowSearch, left_out_residual, row_diagnosis
from stiffcal.diagnosis.row_scan import scan_row_candidates
from stiffcal.diagnosis.search import search_in
from stiffcal.experiments.friction.problem import friction_problems
from stiffcal.experiments.friction.rows import steady_rows
from stiffcal.experiments.friction.runs import FrictionRun, reduce_friction
from stiffcal.measurements.load_states import RunInfo
from stiffcal.model.catalogue import find_effects
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.joint_strokes import LAW, robot, to_and_fro

Law = Callable[[Floats, Floats, Floats], Floats]
SPEEDS = (0.02, 0.04, 0.08, 0.15, 0.3, 0.5, 0.8, 1.2)
NOISE = 1.0


def searched(law: Law, joint: int = 1, temperature: bool = True, seed: int = 0) -> tuple[RowSearchContext, RowSearch]:
    """Return the search in runs at eight speeds; ``law`` gives torque at angle, velocity and warmth, K."""
    rng = np.random.default_rng(seed)
    runs, begins = [], 0.0
    for number in rng.permutation(len(SPEEDS)):
        time, angle = to_and_fro(SPEEDS[number], cycles=2)
        velocity = np.gradient(angle, time)
        warm = 12.0 * (1.0 - np.exp(-(begins + time) / 300.0)) * np.cos((begins + time) / 80.0)
        torque = 40.0 * np.sign(velocity) + 30.0 * velocity + law(angle, velocity, warm)
        torque += NOISE * rng.normal(size=time.size)
        angles, torques = np.zeros((time.size, 6)), np.zeros((time.size, 6))
        angles[:, joint - 1], torques[:, joint - 1] = angle, torque
        kelvin = 293.15 + warm if temperature else None
        info = RunInfo(f"{SPEEDS[number]:g}", "friction")
        runs.append(FrictionRun(info, None, begins + time, angles, torques, None, kelvin))
        begins += float(time[-1])
    reduction = reduce_friction(runs, robot())
    assert reduction.samples is not None
    placed = (PlacedEffect(LAW, Place("joints", (joint,))),)
    rows = steady_rows(reduction.samples)
    (problem,) = friction_problems(rows, np.arange(len(rows)), placed, robot(), frozenset())
    context = RowSearchContext(problem, find_effects())
    return context, search_in(context, problem.robot)


def named(search: RowSearch) -> set[str]:
    return {missing.candidate.name for missing in search.found}


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_named_where_nothing_is_missing(seed: int) -> None:
    _, search = searched(lambda angle, velocity, warm: 0.0 * angle, seed=seed)
    assert named(search) == set()
    assert not search.unexplained
    assert search.before is not None
    assert search.before.ratio < 1.12


LAWS: dict[str, Law] = {
    "stribeck j1": lambda angle, velocity, warm: 8.0 * np.exp(-np.abs(velocity / 0.06)) * np.sign(velocity),
    "torque-ripple j1": lambda angle, velocity, warm: 2.0 * np.cos(12.0 * angle) - 1.0 * np.sin(12.0 * angle),
    "friction-temperature j1": lambda angle, velocity, warm: -0.3 * warm * np.sign(velocity) - 0.5 * warm * velocity,
    "friction-asymmetry j1": lambda angle, velocity, warm: 1.5 * np.sign(velocity) ** 2,
}


@pytest.mark.parametrize("name", sorted(LAWS))
def test_one_effect_is_named_alone(name: str) -> None:
    _, search = searched(LAWS[name])
    assert named(search) == {name}
    assert not search.unexplained
    assert search.after is not None
    assert search.after.adequate


def test_two_effects_are_both_named() -> None:
    both = (LAWS["stribeck j1"], LAWS["torque-ripple j1"])
    _, search = searched(lambda angle, velocity, warm: both[0](angle, velocity, warm) + both[1](angle, velocity, warm))
    assert named(search) == {"stribeck j1", "torque-ripple j1"}
    values = {parameter.name: parameter for parameter in search.final.parameters}
    assert values["torque-ripple.j1.order"].value == 12.0
    for name, truth in (("stribeck.j1.stribeck", 8.0), ("stribeck.j1.velocity", 0.06), ("torque-ripple.j1.a", 2.0)):
        parameter = values[name]
        assert parameter.value is not None
        assert parameter.std is not None
        assert abs(parameter.value - truth) < 4.0 * parameter.std, name


def test_what_no_effect_accounts_for_is_unexplained_and_follows_the_angle() -> None:
    """Friction that swings with the angle and changes its sign with the direction is outside the catalogue."""
    context, search = searched(lambda angle, velocity, warm: 5.0 * angle**2 * np.sign(velocity))
    assert search.unexplained
    assert [dependence.follows for dependence in context.follows(search.final_scan)][:1] == ["position"]


def test_without_a_logged_temperature_its_effect_is_not_tried() -> None:
    _, search = searched(LAWS["friction-temperature j1"], temperature=False)
    reasons = {effect.effect: effect.needs for effect in search.not_tried}
    assert "friction-temperature" in reasons
    assert "friction-temperature j1" not in named(search)


def test_next_to_weight_a_constant_torque_is_not_tried() -> None:
    _, search = searched(lambda angle, velocity, warm: 300.0 * np.cos(angle), joint=2)
    assert "friction-asymmetry" in {effect.effect for effect in search.not_tried}
    assert named(search) == set()
    assert not search.unexplained


def test_the_answer_has_torques_in_its_measure() -> None:
    context, search = searched(LAWS["stribeck j1"])
    answer = row_diagnosis(context, search)
    assert [effect.effect for effect in answer.missing] == ["stribeck"]
    assert answer.rms.torque is not None
    assert answer.noise is not None
    assert answer.noise.torque is not None
    assert answer.heldout_rms_with_missing is not None
    assert answer.heldout_rms_with_missing.torque == pytest.approx(answer.noise.torque, rel=0.12)
    assert answer.findings[0].size_m is None
    assert answer.findings[0].size_Nm is not None
    assert answer.findings[0].size_Nm > 0.0


def test_what_is_left_out_does_not_depend_on_the_unit_of_whitening() -> None:
    """Where no noise is known, a model is whitened as another one that it is compared with."""
    _, search = searched(LAWS["stribeck j1"])
    fit = replace(search.first.fit, noise=None)
    scan = scan_row_candidates(fit, [])
    twice = scan_row_candidates(fit, [], like=replace(fit, sigma=2.0 * fit.sigma))
    np.testing.assert_allclose(left_out_residual(twice, None), left_out_residual(scan, None), rtol=1e-8)
