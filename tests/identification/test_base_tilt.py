"""The direction of gravity in the base: a parameter known to the tolerance of assembly before any measurement."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.base_load import loaded_by_tilt
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.base_tilt import TOLERANCE, placed_base_tilt
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import placed_frame
from stiffcal.model.catalogue.campaign_effects import placed_robot
from tests.laboratory.absolute_places import TARGET, absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, shifted, six_axes
from tests.laboratory.track_simulator import Track, write_absolute

INCLINED = np.radians(60.0)
N_POSES = 40


def inclined(turn: float = 0.0) -> Chain:
    """Return the six-axis arm with its base inclined by 60° about y, and by a further turn about y, rad."""
    gravity = rotation_from_vector(np.array([0.0, -INCLINED - turn, 0.0])) @ np.array([0.0, 0.0, -9.81])
    return replace(six_axes(), gravity=gravity)


def with_payload(chain: Chain, payload: float, turn: float = 0.0, seed: int = 5) -> LoadStates:
    """Return places of the arm, half of the rows with a payload, the base turned further than `inclined` states."""
    drives = on_all_joints(JointCompliance(), 6, [{"c": 1.0 / float(k)} for k in SIX_STIFFNESS])
    true = replace(chain, gravity=rotation_from_vector(np.array([0.0, -turn, 0.0])) @ chain.gravity)
    states = absolute_states(chain, N_POSES, seed)
    states = replace(
        states, setup=replace(states.setup, load_is_weight=True, wrench_point=Attachment(7, shifted(0, 0, 0.2)))
    )
    weight = np.zeros((N_POSES, 6))
    weight[::2, :3] = payload * true.gravity
    measured = measured_by(CompliantRobot(true, tuple(drives)), states, seed, wrench=weight)
    weight[::2, :3] = payload * chain.gravity  # as the manifest's gravity has it
    return replace(measured, wrench=weight)


def fitted(states: LoadStates, chain: Chain, springs: tuple[int, ...] = (1, 2, 3, 4, 5, 6), tilt: bool = True) -> Fit:
    drives = [drive for drive in on_all_joints(JointCompliance(), 6) if drive.place.joints[0] in springs]
    frames = (placed_frame("tracker", with_orientation=True), placed_frame(TARGET, with_orientation=False))
    base = (placed_base_tilt(chain),) if tilt else ()
    placed = (*frames, *base, *on_all_joints(LinkGeometry(), 6), *drives)
    return identify_parameters(states, CompliantRobot(chain, placed))


def test_a_turned_base_has_gravity_turned_back_in_its_axes() -> None:
    chain = six_axes()
    tilt = placed_base_tilt(chain)
    turned = tilt.adjusted_chain(chain, {"rx": 0.01, "ry": -0.02})
    base_from_robot_file = rotation_from_vector(np.array([0.01, -0.02, 0.0]))
    np.testing.assert_allclose(turned.gravity, base_from_robot_file.T @ chain.gravity, rtol=1e-12)


@pytest.mark.parametrize(
    ("gravity", "symbols"), [((0, 0, 9.81), "x y"), ((-9.0, 3.0, 2.0), "y z"), ((1.0, 9.0, -2.0), "x z")]
)
def test_the_axis_nearest_to_gravity_is_no_parameter(gravity: tuple[float, float, float], symbols: str) -> None:
    tilt = placed_base_tilt(replace(six_axes(), gravity=np.array(gravity)))
    names = [tilt.parameter_name(spec.symbol) for spec in tilt.effect.parameters]
    assert names == [f"frame.base.r{axis}" for axis in symbols.split()]


@pytest.mark.parametrize("is_weight", [True, False])
def test_columns_match_differences_of_the_balance(is_weight: bool) -> None:
    """A payload's weight turns with gravity, and what a sensor reads does not."""
    chain = inclined()
    states = with_payload(chain, 60.0)
    states = replace(states, setup=replace(states.setup, load_is_weight=is_weight))
    drives = on_all_joints(JointCompliance(), 6, [{"c": 1.0 / float(k)} for k in SIX_STIFFNESS])
    robot = CompliantRobot(chain, (placed_base_tilt(chain), *drives))
    data = observe(states, chain)
    columns = [column for column in free_columns(robot) if column.placed == 0]
    (block,) = evaluate(robot, data, columns)
    for column, found in zip(columns, block.columns, strict=True):
        name = robot.placed[0].parameter_name(column.symbol)
        ahead, back = (moved(robot.with_values({name: step}), data) for step in (1e-4, -1e-4))
        expected = (ahead - back) / 2e-4
        assert np.abs(expected).max() > 1e-4  # m per rad
        # that the shape sags further is left out of columns: sag over reach, 5 mm over 1 m
        np.testing.assert_allclose(found, expected, atol=0.02 * float(np.abs(expected).max()))


def moved(robot: CompliantRobot, data: object) -> Floats:
    return np.concatenate([block.predicted for block in evaluate(robot, data)], axis=1)  # type: ignore[arg-type]


def test_springs_are_right_where_the_base_is_turned_further_than_stated() -> None:
    """By 20 mrad, four times the tolerance; taken for known, it makes the springs wrong."""
    chain = inclined()
    states = with_payload(chain, 150.0, turn=0.02)
    errors = {}
    for tilt in (True, False):
        fit = fitted(states, chain, tilt=tilt)
        springs = [f"joint-compliance.j{k}.c" for k in range(1, 7) if f"joint-compliance.j{k}.c" in fit.free_names]
        assert len(springs) >= 4
        at = [fit.free_names.index(name) for name in springs]
        away = np.array([fit.robot.values()[name] - 1.0 / SIX_STIFFNESS[int(name[18]) - 1] for name in springs])
        errors[tilt] = float(away @ np.linalg.solve(fit.covariance[np.ix_(at, at)], away)) / len(at)
        if tilt:
            found = fit.parameter("frame.base.ry")
            assert found.std is not None
            assert found.value is not None
            assert found.std < 0.5 * TOLERANCE
            # the prior pulls it to 0 by (std / tolerance)² of it
            assert abs(found.value - 0.02) < 4.0 * found.std + 0.02 * (found.std / TOLERANCE) ** 2
    assert errors[True] < 4.0  # reduced χ² of four to six: p = 0.003
    assert errors[False] > 5.0  # p = 1e-4


def test_a_turn_that_no_place_shows_stays_free_and_is_not_reported() -> None:
    chain = inclined()
    states = absolute_states(chain, N_POSES, 3)
    drives = on_all_joints(JointCompliance(), 6, [{"c": 1e-3 / float(k)} for k in SIX_STIFFNESS])
    fit = fitted(measured_by(CompliantRobot(chain, tuple(drives)), states, 3), chain, springs=(2,))
    assert fit.parameter("frame.base.ry").value is None
    assert {"frame.base.ry", "frame.base.rz"}.isdisjoint(fit.left_at_neutral)
    causes = {name: ambiguity.cause for ambiguity in fit.ambiguities for name in ambiguity.names}
    assert causes["frame.base.ry"] is Undetermined.ASSEMBLY


def test_a_joint_that_only_the_turn_loads_has_no_compliance() -> None:
    """The first axis of an upright arm; the others carry weight."""
    chain = six_axes()
    states = with_payload(chain, 100.0, turn=2e-3)
    robot = CompliantRobot(chain, (placed_base_tilt(chain), *on_all_joints(JointCompliance(), 6)))
    names = loaded_by_tilt(robot, observe(states, chain), frozenset())
    assert names == {"joint-compliance.j1.c"}
    fit = fitted(states, chain)
    assert fit.parameter("joint-compliance.j1.c").value is None
    assert Undetermined.TILT_LOADED in [ambiguity.cause for ambiguity in fit.ambiguities]


def test_it_is_a_parameter_where_sags_of_an_inclined_axis_are_measured_from_an_estimated_tracker(
    tmp_path: Path,
) -> None:
    def names(folder: Path) -> set[str]:
        return {placed.place.label for placed in placed_robot(load_campaign(folder)).placed}

    upright = write_absolute(tmp_path / "upright", Track.arm(1, 0.0), 1, n=2)
    assert "base" not in names(upright)
    folder = write_absolute(tmp_path / "inclined", Track.arm(1, INCLINED), 1, n=2)
    assert "base" in names(folder)
    manifest, model = folder / "campaign.toml", folder / "model.toml"
    text, effects = manifest.read_text(), model.read_text()
    model.write_text(effects.split('[[effects]]\ntype = "joint-compliance"')[0])
    assert "base" not in names(folder)  # nothing gives
    model.write_text(effects)
    known = 'parent = "base"\nxyz_m = [4.0, -2.0, 1.0]\n'
    manifest.write_text(text.replace('parent = "base"\nestimate = true\n', known))
    assert "base" not in names(folder)  # the manifest states where the tracker stands in the base
