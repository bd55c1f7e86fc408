"""A law, a geometry, an instrument and a motion, each a dropped-in file with the one method that it is made of."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import replace

import pytest

from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.kinds.friction.fitting.part_fit import PartFit
from stiffcal.kinds.friction.fitting.row_columns import RowColumns
from stiffcal.kinds.friction.fitting.torque_rows import steady_rows
from stiffcal.kinds.friction.logs.runs import reduce_friction
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Effect, EffectAtRest, Geometry, Instrument, Law, Place
from stiffcal.model.motion import Motion
from tests.laboratory.absolute_places import absolute_states, measured_by
from tests.laboratory.dropped_in import dropped_in
from tests.laboratory.joint_strokes import LAW, friction_runs
from tests.laboratory.joint_strokes import robot as friction_robot
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import medium_robot, played

SETUP = Place("setup")
INTERFACES = (Law, Geometry, Instrument, Motion)


@pytest.fixture(scope="module")
def effects() -> Iterator[Mapping[str, Effect]]:
    with dropped_in("effects", "effect_kinds"):
        yield built_in_effects()


def with_effect(robot: CompliantRobot, effect: Effect, place: Place, **values: float) -> CompliantRobot:
    return replace(robot, placed=(*robot.placed, PlacedEffect(effect, place, values)))


def test_a_law_is_fitted(effects: Mapping[str, Effect]) -> None:
    effect, place = effects["angle-stiffness"], Place("joints", (3,))
    states = played(with_effect(medium_robot(), effect, place, c=1.5e-6))
    fit = identify_parameters(states, with_effect(medium_robot(), effect, place), Settings())
    assert fit.robot.values()["angle-stiffness.j3.c"] == pytest.approx(1.5e-6, rel=1e-6)


def test_an_instrument_is_fitted(effects: Mapping[str, Effect]) -> None:
    states, effect = played(medium_robot()), effects["crossed-reading"]
    position = states.position.copy()
    for run in range(len(states.runs)):
        own = states.run == run
        position[own, 0, 1] += 0.02 * (position[own, 0, 0] - position[own, 0, 0][0])
    fit = identify_parameters(
        replace(states, position=position), with_effect(medium_robot(), effect, SETUP), Settings()
    )
    assert fit.robot.values()["crossed-reading.setup.share"] == pytest.approx(0.02, rel=1e-6)


def test_a_geometry_is_fitted(effects: Mapping[str, Effect]) -> None:
    chain, effect = six_axes(), effects["low-shoulder"]
    bare = CompliantRobot(chain, ())
    states = measured_by(with_effect(bare, effect, SETUP, drop=5e-4), absolute_states(chain, 40, 3), 1, sigma=0.0)
    fit = identify_parameters(states, with_effect(bare, effect, SETUP), Settings())
    assert fit.robot.values()["low-shoulder.setup.drop"] == pytest.approx(5e-4, rel=1e-6)


def test_a_motion_is_fitted(effects: Mapping[str, Effect]) -> None:
    samples = reduce_friction(friction_runs({"coulomb": 50.0, "viscous": 80.0}), friction_robot()).samples
    assert samples is not None
    place, rows = Place("joints", (2,)), steady_rows(samples)
    law, drag = PlacedEffect(LAW, place), PlacedEffect(effects["sine-drag"], place)
    before = PartFit.of(rows, (law, drag), friction_robot()).values["sine-drag.j2.drag"]
    added = 12.0 * RowColumns(rows, friction_robot()).of(drag.effect, place, {})["drag"]
    after = PartFit.of(replace(rows, torque=rows.torque + added), (law, drag), friction_robot())
    assert after.values["sine-drag.j2.drag"] - before == pytest.approx(12.0, rel=1e-6)


def test_every_effect_is_of_one_kind(effects: Mapping[str, Effect]) -> None:
    for name, effect in effects.items():
        for form in effect.forms or (effect,):
            assert sum(isinstance(form, kind) for kind in INTERFACES) == 1, name
            assert form.name == name


def test_the_interfaces_are_small() -> None:
    def methods(kind: type) -> set[str]:
        return {name for name, _ in inspect.getmembers(kind, callable) if not name.startswith("_")}

    assert methods(Effect) == {"places", "at", "impossible", "spec", "describe"}
    at_rest = methods(Effect) | {"lacking", "covariate", "nonlinear_grid"}
    assert methods(EffectAtRest) == at_rest
    assert methods(Law) == at_rest | {"terms", "scalar_laws"}
    assert methods(Geometry) == at_rest | {"adjusted_chain", "adjusted", "geometry_terms"}
    assert methods(Instrument) == at_rest | {"adjusted", "observation_columns"}
    assert methods(Motion) == methods(Effect) | {
        "torque_columns", "motion_columns", "motion_grid", "motion_covariate", "lacking_motion",
    }  # fmt: skip
