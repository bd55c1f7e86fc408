"""Columns are derivatives of the whole prediction, the balance found anew: every effect, on robots drawn at random."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import ParameterColumn, free_columns
from stiffcal.identification.derivatives import observation, rest_tangent
from stiffcal.identification.derivatives.observation import Observations, derivatives, evaluate, predicted, rests
from stiffcal.identification.fitting.identify import fit_problem
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.chain import BeamFrame
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Effect, ParameterRole
from tests.laboratory.absolute_places import absolute_states
from tests.laboratory.random_robots import draw_robot
from tests.laboratory.simulated_states import cycles_of, joint_springs, played

# Of the column's length. The differences err by the square of their step, 1e-6. A law's answer to a change of the
# wrench that the balance makes is taken over 1 N: a hundredth of a column, it errs by the law's curvature.
SMOOTH = 2e-5
# Laws with a memory or a corner answer otherwise in a few states: where they turn, and within 1 N of the corner.
CORNERED = 3e-3
WITH_CORNERS = {
    "asymmetric-stiffness", "backlash", "creep", "friction-hysteresis", "presliding", "seat-shift", "two-slope",
}  # fmt: skip
# m and rad that a typical value makes by rounding, over the step.
ROUNDING = 1e-11
STEP = 1e-3
PER_TARGET = ("position", "rotation", "deflection", "sigma", "markers_measured")
EFFECTS = built_in_effects()


@pytest.fixture(autouse=True)
def converged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Find balances to rounding, so that differences of 1e-3 of a parameter compare to 1e-6."""
    monkeypatch.setattr(observation, "FIT_TOLERANCE", 1e-14)
    monkeypatch.setattr(rest_tangent, "TOLERANCE", 1e-9)


def robot_with(effect: Effect, number: int, rng: np.random.Generator) -> CompliantRobot:
    """Return springs and the effect, at one of its places."""
    drawn = draw_robot(rng)
    while drawn.chain.n_joints != 6:
        drawn = draw_robot(rng)
    end = np.eye(4)
    end[0, 3] = 0.8
    chain = replace(
        drawn.chain,
        beams={"swing": BeamFrame(2, end, 0.8)},
        gear_orders=((80,),) * drawn.chain.n_joints,
        compensator={"joint": 2, "anchor_m": [-0.4, 0.0, -0.2], "arm_m": [0.35, 0.1, 0.0]},
    )
    if effect.name == "joint-compliance":
        return CompliantRobot(chain, joint_springs(chain, drawn.stiffness).placed)
    places = effect.places(chain)
    place = places[number % len(places)]
    at = effect.at(place, chain)
    values = {spec.symbol: spec.typical * rng.uniform(0.6, 1.4) for spec in at.parameters if not spec.discrete}
    values |= {spec.symbol: spec.typical for spec in at.parameters if spec.discrete}
    springs = joint_springs(chain, drawn.stiffness)
    return replace(springs, placed=(*springs.placed, PlacedEffect(at, place, values)))


def states_of(robot: CompliantRobot, absolute: bool, rng: np.random.Generator) -> LoadStates:
    """Return states whose readings do not matter: loads in three directions, or loaded places."""
    chain = robot.chain
    load = [cycles_of(np.linalg.qr(rng.normal(size=(3, 3)))[0], cycles=1) for _ in range(2)]
    if not absolute:
        return played(
            joint_springs(chain, np.full(chain.n_joints, 1e6)), runs=2, wrench=load, seed=int(rng.integers(99))
        )
    states = absolute_states(chain, sum(len(one) for one in load), seed=int(rng.integers(99)))
    return replace(states, wrench=np.concatenate(load))


def prediction(robot: CompliantRobot, data: Observations) -> Floats:
    return predicted(robot, data, *rests(robot, data))


def difference(robot: CompliantRobot, data: Observations, column: ParameterColumn) -> Floats:
    """Return (m, n) the derivative by an amplitude, or another parameter, by a central difference."""
    placed = robot.placed[column.placed]
    spec, name = placed.effect.spec(column.symbol), placed.parameter_name(column.symbol)
    value = placed.values[column.symbol]
    step = STEP * max(abs(value), spec.size)
    low, high = (robot.with_values({name: value + sign * step}) for sign in (-1.0, 1.0))
    width = 2.0 * step
    if column.role is ParameterRole.AMPLITUDE:
        width = high.placed[column.placed].amplitude(column.symbol) - low.placed[column.placed].amplitude(column.symbol)
    return (prediction(high, data) - prediction(low, data)) / width


@pytest.mark.parametrize("absolute", [False, True], ids=["displacements", "places"])
@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_columns_are_derivatives_of_the_whole_prediction(name: str, absolute: bool) -> None:
    rng = np.random.default_rng([sorted(EFFECTS).index(name), absolute])
    off: dict[str, float] = {}
    for number in (0, -1):
        robot = robot_with(EFFECTS[name], number, rng)
        data = fit_problem(states_of(robot, absolute, rng), robot).data
        columns = free_columns(robot)
        # of the six springs next to an effect one, in turn: each stands next to seven effects, and all by themselves
        turn = (sorted(EFFECTS).index(name) + number) % robot.chain.n_joints
        left_out = [place != turn and one.effect.name != name for place, one in enumerate(robot.placed)]
        found = np.concatenate([block.columns for block in evaluate(robot, data, columns)], axis=2)
        for row, column in enumerate(columns):
            if left_out[column.placed]:
                continue
            if not absolute and robot.placed[column.placed].changes_geometry:
                assert not found[row].any()  # displacements depend on it by its square alone: its tolerance is a prior
                continue
            exact = difference(robot, data, column)
            away = float(np.linalg.norm((found[row] - exact)[data.measured_mask]))
            share = CORNERED if name in WITH_CORNERS else SMOOTH
            size = float(np.linalg.norm(exact[data.measured_mask]))
            spec = robot.placed[column.placed].effect.spec(column.symbol)
            if away > share * size + ROUNDING / spec.amplitude_of(spec.size):
                off[robot.placed[column.placed].parameter_name(column.symbol)] = away / (size or 1.0)
    assert off == {}


@pytest.mark.parametrize("joint", [2, 4])
def test_bodies_hang_at_any_frame_and_move_with_other_joints(joint: int) -> None:
    """Targets on links inboard and outboard of a law: it moves those behind it, and the others by the balance alone."""
    rng = np.random.default_rng(11)
    drawn = robot_with(EFFECTS["joint-compliance"], 0, rng)
    chain = drawn.chain
    place = next(one for one in EFFECTS["joint-full"].places(chain) if one.joints == (joint,))
    effect = EFFECTS["joint-full"].at(place, chain)
    values = {spec.symbol: spec.typical for spec in effect.parameters}
    robot = replace(drawn, placed=(*drawn.placed, PlacedEffect(effect, place, values)))
    states = states_of(robot, False, rng)
    at = [np.vstack([np.column_stack([np.eye(3), rng.uniform(-0.3, 0.3, 3)]), [0.0, 0.0, 0.0, 1.0]]) for _ in range(4)]
    targets = tuple(Attachment(body, frame) for body, frame in zip((1, 3, 4, 7), at, strict=True))
    setup = replace(states.setup, targets=targets, target_names=("column", "arm", "wrist", "tool"))
    per_target: dict[str, Any] = {field: np.repeat(getattr(states, field), 4, axis=1) for field in PER_TARGET}
    data = fit_problem(replace(states, setup=setup, **per_target), robot).data
    columns = [column for column in free_columns(robot) if column.placed == len(robot.placed) - 1][::5]
    as_drawn = replace(robot, deformed=False)
    found, first_order = (derivatives(one, data, columns) for one in (robot, as_drawn))
    for row, column in enumerate(columns):
        exact = difference(robot, data, column)
        size = float(np.linalg.norm(exact))
        for body, target in enumerate(targets):
            of_body = data.body == body
            assert np.linalg.norm((found[row] - exact)[of_body]) <= SMOOTH * size, target.body
            assert exact[of_body].any()
            assert first_order[row][of_body].any() == (target.body >= joint)
