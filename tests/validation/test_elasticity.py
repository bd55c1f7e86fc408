"""Compliances that places show, and those that an error of the joint's angle explains as well."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.ingest.checks.absolute import _how_to_determine
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.kinematics import jacobians
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from stiffcal.validation.elasticity import _summary, _with_waves, elasticity_of, payload_that_shows
from stiffcal.validation.elasticity_results import Elasticity, JointElasticity
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

if TYPE_CHECKING:
    from stiffcal.identification.fitting.fit import Fit

N_POSES = 150


def judged(springs: bool, wave: float) -> Elasticity:
    """Return the verdict on a robot whose joints give or not, joint 2 with an eccentricity of so many rad."""
    chain = six_axes()
    softness = [{"c": (1.0 / float(k)) if springs else 0.0} for k in SIX_STIFFNESS]
    true = (
        *on_all_joints(JointCompliance(), 6, softness),
        PlacedEffect(JointEccentricity(), Place("joints", (2,)), {"a": wave, "b": 0.0, "order": 1.0}),
    )
    states = measured_by(CompliantRobot(chain, true), absolute_states(chain, N_POSES, 5), 6)
    model = (*on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6))
    found = elasticity_of(states, identify_parameters(states, CompliantRobot(chain, model)))
    assert found is not None
    return found


@pytest.mark.long
def test_springs_that_weight_turns_are_identified() -> None:
    found = judged(springs=True, wave=0.0)
    verdicts = {joint.joint: joint.verdict for joint in found.joints}
    assert verdicts[1] != "identified"  # weight on an upright robot does not turn it
    assert verdicts[2] == verdicts[3] == "identified"
    assert found.verdict == "partly-identified"


@pytest.mark.parametrize("wave", [1e-3, -1e-3])
def test_an_eccentricity_is_no_elasticity(wave: float) -> None:
    found = judged(springs=False, wave=wave)
    assert found.verdict == "not-identified"
    (second,) = [joint for joint in found.joints if joint.joint == 2]
    assert second.verdict != "identified"
    assert second.payload_kg is not None
    assert second.payload_kg > 0.0


def test_a_softer_joint_needs_less_payload() -> None:
    """The mass goes with one over the compliance that it is to show: by definition of c τ."""
    chain = six_axes()
    robot = CompliantRobot(chain, tuple(on_all_joints(JointCompliance(), 6, [{"c": 1e-6}] * 6)))
    states = measured_by(robot, absolute_states(chain, N_POSES, 7), 8)
    fit = identify_parameters(states, robot)
    stiff, soft = payload_that_shows(fit, 2, 1e-6), payload_that_shows(fit, 2, 1e-5)
    assert stiff is not None
    assert soft == pytest.approx(stiff / 10.0)
    assert payload_that_shows(fit, 1, 1e-5) is None
    assert np.isfinite(stiff)
    # within 2 to 100 % of what the maker allows
    assert soft is not None
    for share, shown in ((0.9, None), (1.1, soft), (100.0, 2.0 * soft)):
        rated = replace(fit.robot, chain=replace(fit.robot.chain, rated_payload=share * soft))
        assert payload_that_shows(replace(fit, robot=rated), 2, 1e-5) == (shown and pytest.approx(shown))


@pytest.mark.parametrize(("range_deg", "asks_joint_2"), [(59.0, True), (61.0, False)])
def test_larger_motions_are_advised_of_joints_that_moved_little(range_deg: float, asks_joint_2: bool) -> None:
    chain = six_axes()
    angles = np.deg2rad(np.outer(np.full(6, 170.0), [0.0, 0.5, 1.0]))
    angles[1] *= range_deg / 170.0
    fit = SimpleNamespace(data=SimpleNamespace(angles=angles), robot=SimpleNamespace(chain=chain))
    advice = _how_to_determine(cast("Fit", fit))
    assert ("joint 2" in advice) is asks_joint_2
    assert "joint 1" not in advice


def robot_with_wave(joint: int, wave: float, softness: list[float], seed: int) -> tuple[CompliantRobot, LoadStates]:
    """Return the six-axis model, and places of a robot in which one joint has an eccentricity of so many rad."""
    chain = six_axes()
    true = (
        *on_all_joints(JointCompliance(), 6, [{"c": c} for c in softness]),
        PlacedEffect(JointEccentricity(), Place("joints", (joint,)), {"a": 0.0, "b": wave, "order": 1.0}),
    )
    states = measured_by(CompliantRobot(chain, true), absolute_states(chain, N_POSES, seed), seed + 1)
    return CompliantRobot(chain, (*on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6))), states


@pytest.mark.long
def test_an_eccentricity_of_another_joint_is_no_elasticity_either() -> None:
    """Joint 5's wave looks like a spring of joint 4, next to a wave of joint 4 too; joint 2's true spring stays."""
    model, states = robot_with_wave(5, 2e-3, [0.0, 1.0 / float(SIX_STIFFNESS[1]), 0.0, 0.0, 0.0, 0.0], seed=5)
    fit = identify_parameters(states, model)
    (fourth,) = [p for p in fit.parameters if p.name == "joint-compliance.j4.c"]
    assert fourth.value is not None
    assert fourth.value > 2e-5  # rad/(N·m), of a joint that is rigid
    found = elasticity_of(states, fit)
    assert found is not None
    verdicts = {joint.joint: joint.verdict for joint in found.joints}
    assert verdicts[2] == "identified"
    assert verdicts[4] == verdicts[5] == "like-eccentricity"
    assert all(verdict != "identified" for joint, verdict in verdicts.items() if joint != 2)


def test_what_no_effect_explains_is_no_elasticity_where_regions_disagree() -> None:
    """A smooth error of 0.3 mm looks like a spring of joint 4 next to all waves, of another size in each region."""
    chain, rng = six_axes(), np.random.default_rng(5)
    states = measured_by(CompliantRobot(chain, ()), absolute_states(chain, N_POSES, 5), 6)
    along = rng.normal(size=(3, 6))
    waves = np.sin(states.joints @ along.T + rng.uniform(0.0, 6.0, 3))
    states = replace(states, position=states.position + 3e-4 * np.sqrt(2.0) * waves[:, None])
    model = CompliantRobot(chain, (*on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6)))
    found = elasticity_of(states, identify_parameters(states, model))
    assert found is not None
    assert found.verdict == "not-identified"
    assert {joint.joint: joint.verdict for joint in found.joints}[4] == "differs-by-region"


def test_an_eccentricity_of_another_order_in_the_model_does_not_stand_for_order_1() -> None:
    places = [PlacedEffect(JointEccentricity(), Place("joints", (k,)), {"order": float(k)}) for k in (1, 2)]
    robot = CompliantRobot(six_axes(), (*on_all_joints(JointCompliance(), 6), *places))
    waves = _with_waves(robot, (1, 2, 3)).placed[6:]
    assert [(wave.place.joints, wave.values["order"]) for wave in waves] == [((k,), 1.0) for k in (1, 2, 3)]
    assert _with_waves(robot, (1,)) is robot


def test_the_payload_is_the_one_that_shows_the_compliance_to_a_fifth() -> None:
    """Least squares of one column c τ × lever per kilogram, in half of the poses: five standard errors."""
    chain = six_axes()
    robot = CompliantRobot(chain, tuple(on_all_joints(JointCompliance(), 6, [{"c": 1e-6}] * 6)))
    states = measured_by(robot, absolute_states(chain, N_POSES, 7), 8)
    fit = identify_parameters(states, robot)
    jacobian = jacobians(chain, chain.model_angles(states.joints), Attachment(7, np.eye(4)))[:, :3]
    torque = np.einsum("nij,i->nj", jacobian, chain.gravity)
    column = 1e-5 * jacobian[:, :, 2] * torque[:, [2]]
    scatter = np.sqrt(np.sum(fit.residual[:3] ** 2) / fit.dof)
    wanted = 5.0 * scatter / np.sqrt(np.sum(column**2) / 2.0)
    assert payload_that_shows(fit, 3, 1e-5) == pytest.approx(wanted, rel=1e-6)


def test_the_payload_gives_what_is_promised_and_not_ten_times_more() -> None:
    """To a fifth by the flange alone; the robot's own weight and the target's longer lever add to it."""
    chain = six_axes()
    values = [{"c": 1.0 / stiffness} for stiffness in SIX_STIFFNESS]
    robot = CompliantRobot(chain, tuple(on_all_joints(JointCompliance(), 6, values)))
    states = measured_by(robot, absolute_states(chain, N_POSES, 7), 8)
    fit = identify_parameters(states, robot)
    point = Attachment(chain.n_joints + 1, np.eye(4))
    for joint in (4, 5):
        compliance = 1.0 / SIX_STIFFNESS[joint - 1]
        mass = payload_that_shows(fit, joint, compliance)
        assert mass is not None
        wrench = np.zeros((N_POSES, 6))
        wrench[::2, :3] = mass * chain.gravity
        hung = replace(states, setup=replace(states.setup, wrench_point=point))
        loaded = measured_by(robot, hung, 9, wrench=wrench)
        std = identify_parameters(loaded, robot).parameter(f"joint-compliance.j{joint}.c").std
        assert std is not None
        assert 0.02 < std / compliance < 0.2


def test_each_payload_is_stated_with_its_joint() -> None:
    open_joints = {1: ("no-torque", None), 4: ("not-above-zero", 210.2), 5: ("like-eccentricity", 27.3)}
    summary = _summary(
        [
            JointElasticity(joint=joint, verdict=verdict, why="", payload_kg=mass)  # type: ignore[arg-type]
            for joint, (verdict, mass) in open_joints.items()
        ]
    )
    assert summary.payload_kg == 27.3
    assert summary.why.endswith("at the flange in half of the poses: 27 kg for joint 5, 210 kg for joint 4")
