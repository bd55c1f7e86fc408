"""A value that model.toml holds wrong is named itself, and no effect for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.setting_results import SettingKind
from stiffcal.identification.fitting.identify import Settings, fit_problem
from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.judgement.document import diagnosis_result
from stiffcal.judgement.settings_off import given_frames
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.assembled.measured_frames import placed_frame
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Effect, Place
from stiffcal.model.summary import EffectAt, Where
from tests.laboratory.absolute_places import TARGET, absolute_states, measured_by
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)
FIXED = "joint-compliance.j4.c"


def catalogue() -> Mapping[str, Effect]:
    return {name: find_effects()[name] for name in ("joint-compliance", "backlash", "bearing-tilt", "axis-coupling")}


def searched(states: LoadStates, robot: CompliantRobot, fixed: frozenset[str]) -> DiagnosedStates:
    return diagnose_states(states, robot, catalogue(), Settings(fixed=fixed))


def with_fixed_fourth(factor: float) -> CompliantRobot:
    """Return the joints' springs, the fourth of so many times its true compliance."""
    springs, true = joint_springs(six_axes()), medium_robot().placed[3].values["c"]
    fourth = PlacedEffect(springs.placed[3].effect, Place("joints", (4,)), {"c": factor * true})
    return replace(springs, placed=(*springs.placed[:3], fourth, *springs.placed[4:]))


def test_a_stiffness_that_is_fixed_wrong_is_named_and_no_effect() -> None:
    states = played(medium_robot(), runs=8, noise=NOISE, seed=3)
    search = searched(states, with_fixed_fourth(1.5), frozenset({FIXED}))
    (setting,) = diagnosis_result(search).contradicted
    assert (setting.setting, setting.parameter) == (SettingKind.FIXED, FIXED)
    true = medium_robot().placed[3].values["c"]
    assert setting.free_value == pytest.approx(true, abs=4.0 * (setting.free_std or 0.0))
    assert setting.fixed_at == pytest.approx(1.5 * true)
    assert search.found == ()
    assert not search.unexplained


def test_a_stiffness_that_is_fixed_right_is_left() -> None:
    states = played(medium_robot(), runs=8, noise=NOISE, seed=3)
    search = searched(states, with_fixed_fourth(1.0), frozenset({FIXED}))
    assert diagnosis_result(search).contradicted == []
    assert search.found == ()


def test_what_is_missing_is_not_taken_for_a_wrong_value() -> None:
    """Backlash makes the joint seem softer than its spring is, which is fixed at what it is."""
    backlash = PlacedEffect(find_effects()["backlash"], Place("joints", (4,)), {"width": 2e-3, "band": 1.0})
    robot = medium_robot()
    states = played(replace(robot, placed=(*robot.placed, backlash)), runs=8, noise=NOISE, seed=3)
    search = searched(states, with_fixed_fourth(1.0), frozenset({FIXED}))
    assert [missing_effect.candidate.name for missing_effect in search.found] == ["backlash j4"]
    assert diagnosis_result(search).contradicted == []


def test_the_first_order_balance_is_switched_where_the_deformation_shows() -> None:
    soft = medium_robot()
    placed = tuple(replace(one, values={"c": 10.0 * one.values["c"]}) for one in soft.placed)
    states = played(replace(soft, placed=placed), runs=8, noise=NOISE, seed=3)
    search = searched(states, joint_springs(six_axes(), deformed=False), frozenset())
    assert [setting.setting for setting in diagnosis_result(search).contradicted] == [SettingKind.BALANCE]
    assert search.found == ()
    assert np.sqrt(np.sum(search.last.base.heldout) / search.last.dof) < 1.05


def places_of(motion: Floats, n: int = 60, seed: int = 2) -> LoadStates:
    """Return n absolute places; the tracker is off the manifest's frame by a motion (6,): m, and a turn in rad."""
    chain = six_axes()
    states = absolute_states(chain, n, seed)
    setup = replace(states.setup, estimated=(TARGET,))
    springs = joint_springs(chain)
    values = {f"joint-compliance.j{k + 1}.c": 1.0 / stiffness for k, stiffness in enumerate(SIX_STIFFNESS)}
    measured = measured_by(springs.with_values(values), replace(states, setup=setup), seed)
    return replace(measured, position=measured.position @ rotation_from_vector(motion[3:]).T + motion[:3])


def searched_with_given_tracker(states: LoadStates) -> DiagnosedStates:
    """Return what springs lack in absolute places whose tracker is given."""
    robot = joint_springs(six_axes())
    robot = replace(robot, placed=(placed_frame(TARGET, False), *robot.placed))
    effects = {name: find_effects()[name] for name in ("link-geometry", "bearing-tilt")}

    return diagnose_states(states, robot, effects)


@pytest.mark.parametrize("motion", [(0.0, 0.0, 1e-3, 0.0, 0.0, 5e-4), (0.0,) * 6])
def test_a_trackers_frame_that_is_given_wrong_is_named_and_no_geometry(motion: tuple[float, ...]) -> None:
    search = searched_with_given_tracker(places_of(np.array(motion)))
    # that joint 2 stands higher is the same as the shift along z
    named = [(setting.setting, setting.parameter) for setting in diagnosis_result(search).contradicted]
    assert named == ([(SettingKind.FRAME, "frame.tracker")] if any(motion) else [])
    assert search.found == ()
    assert not search.unexplained


@pytest.mark.parametrize(("direction", "n"), [*zip(range(6), (10, 12, 15, 20, 10, 15), strict=True)])
def test_of_few_poses_the_frame_is_named_and_never_the_geometry_alone(direction: int, n: int) -> None:
    """A shift across axis 1 and a tilt are joint 1's geometry too: the error in poses left out decides nothing."""
    motion = np.zeros(6)
    motion[direction] = 1e-3 if direction < 3 else 5e-4
    search = searched_with_given_tracker(places_of(motion, n, 2))
    (setting,) = diagnosis_result(search).contradicted
    assert (setting.setting, setting.parameter) == (SettingKind.FRAME, "frame.tracker")
    assert (search.found, search.unexplained) == ((), False)
    if direction not in (2, 5):
        assert EffectAt(effect="link-geometry", where=Where(joints=[1])) in setting.alternatives


def test_frames_that_are_tried_are_those_that_the_manifest_gives() -> None:
    states, robot = places_of(np.zeros(6)), joint_springs(six_axes())
    data = fit_problem(states, robot).data
    assert [frame.place.frame for frame in given_frames(robot, data)] == ["tracker"]
    assert not given_frames(replace(robot, placed=(placed_frame("tracker", True), *robot.placed)), data)
