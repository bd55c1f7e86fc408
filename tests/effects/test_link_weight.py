"""link-weight: the first moment of a link differs from robot.toml's by (mx, my, 0)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from stiffcal.arrays import Floats
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_weight import LinkWeight
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.deformed_chain import deformed_chain, node_wrenches
from stiffcal.model.effect import RZ, Inputs, Place
from tests.laboratory.absolute_places import SIGMA, absolute_states, on_all_joints
from tests.laboratory.effect_bench import bare_states, loads, robot_chain
from tests.laboratory.robots import SIX_STIFFNESS

EFFECT = LinkWeight()
PLACES = EFFECT.places(robot_chain())
MOMENTS: Floats = np.random.default_rng(4).normal(0.0, 3.0, (5, 2))
PAYLOAD = 40.0


def true_chain() -> Chain:
    """Return the robot as it is: every link's weight but the first's acts elsewhere."""
    chain = robot_chain()
    centres = chain.link_com.copy()
    centres[1:, :2] += MOMENTS / chain.link_mass[1:, None]
    return replace(chain, link_com=centres)


def moved(chain: Chain, values: Floats = MOMENTS) -> tuple[PlacedEffect, ...]:
    """Return the effect on all its links."""
    return tuple(
        PlacedEffect(EFFECT, place, {"mx": float(mx), "my": float(my)})
        for place, (mx, my) in zip(EFFECT.places(chain), values, strict=True)
    )


def test_no_centre_of_mass_lies_outside_the_robot() -> None:
    """What a link carries, at the length of all links, is the largest first moment; robots are far below."""
    chain = robot_chain()
    limits = []
    for place, moment in zip(PLACES, MOMENTS, strict=True):
        effect = EFFECT.at(place, chain)
        assert effect.impossible({"mx": float(moment[0]), "my": float(moment[1])}) is None
        carried = float(chain.link_mass[chain.joint_of_link[place.link] - 1 :].sum())
        reach = float(np.linalg.norm(chain.fixed[:, :3, 3], axis=1).sum())
        assert effect.impossible({"mx": 0.99 * carried * reach, "my": 0.0}) is None
        assert effect.impossible({"mx": 0.0, "my": -1.01 * carried * reach}) is not None
        limits.append(effect.largest)
    assert limits == sorted(limits, reverse=True)
    unknown = replace(chain, masses_known=False)
    assert EFFECT.at(PLACES[0], unknown).impossible({"mx": 1e4}) is None


def test_law_against_pinocchio() -> None:
    """The torques that hold the robot are those of an outside library on the robot as it is."""
    pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")
    from tests.laboratory.pinocchio_robot import gravity_torques, pinocchio_model

    chain = robot_chain()
    changed = CompliantRobot(chain, moved(chain)).adjusted_chain
    states = absolute_states(chain, 6, 2)
    angles = chain.model_angles(states.joints).T
    inputs = Inputs(angles, np.zeros((6, 6)), states.setup)
    carried = node_wrenches(changed, deformed_chain(changed, angles, None), inputs)[1:13:2, RZ]
    outside = pinocchio_model(true_chain())
    expected = np.array([-gravity_torques(outside, q) for q in angles.T]).T
    np.testing.assert_allclose(carried, expected, atol=1e-9 * np.abs(expected).max())


def test_links_before_the_first_axis_that_leaves_the_vertical_are_no_places() -> None:
    chain = robot_chain()
    assert [place.label for place in PLACES] == ["swing", "link3", "link4", "link5", "link6"]
    on_a_wall = replace(chain, gravity=np.array([0.0, 9.81, 0.0]))
    assert len(EFFECT.places(on_a_wall)) == 6
    light = replace(chain, link_mass=chain.link_mass * [1, 1, 1, 1, 1, 0])
    assert Place("links", (), "link6") not in EFFECT.places(light)


def test_it_needs_absolute_places_and_masses() -> None:
    chain = robot_chain()
    assert "absolute" in (EFFECT.lacking(chain, bare_states([0, 1])) or "")
    places = absolute_states(chain, 3, 1)
    assert EFFECT.lacking(chain, places) is None
    assert "masses" in (EFFECT.lacking(replace(chain, masses_known=False), places) or "")


def test_the_covariate_is_the_torque_on_the_links_joint() -> None:
    carried = loads({(3, RZ): [120.0]})
    assert EFFECT.covariate(PLACES[0], robot_chain(), carried).value.tolist() == [120.0]


def weighed(payload: float, n: int = 40) -> LoadStates:
    """Return places at which MuJoCo's robot rests, with a payload in every second pose, and noise."""
    pytest.importorskip("mujoco", reason="mujoco has no wheel for this platform")
    from tests.laboratory.mujoco_robot import MujocoRobot

    chain = true_chain()
    states = absolute_states(chain, n, 5)
    wrench = np.zeros((n, 6))
    wrench[::2, 2] = -9.81 * payload
    rests = MujocoRobot(chain, SIX_STIFFNESS, states.setup).settle(chain.model_angles(states.joints), wrench)
    noise = np.random.default_rng(6).normal(0.0, SIGMA, rests.position.shape)
    return replace(states, position=rests.position + noise, wrench=wrench)


def refitted(states: LoadStates) -> Fit:
    """Fit drives and weights to the places."""
    chain = robot_chain()
    placed = (*on_all_joints(JointCompliance(), 6), *(PlacedEffect(EFFECT, place) for place in PLACES))
    return identify_parameters(states, CompliantRobot(chain, placed))


def test_columns_are_the_slope_of_the_exact_balance() -> None:
    """Against central differences, but for what the chain sags further: lever times force over stiffness, 1 %."""
    chain = robot_chain()
    drives = on_all_joints(JointCompliance(), 6, [{"c": 1.0 / float(k)} for k in SIX_STIFFNESS])
    robot = CompliantRobot(chain, (*drives, *moved(chain)))
    data = observe(absolute_states(chain, 20, 1), chain)
    columns = [column for column in free_columns(robot) if column.symbol in ("mx", "my")]
    rows = np.concatenate([block.columns for block in evaluate(robot, data, columns)], axis=2)
    for column, row in zip(columns, rows, strict=True):
        name = robot.placed[column.placed].parameter_name(column.symbol)
        ends = [predict_observations(robot.with_values({name: robot.values()[name] + step}), data) for step in (1, -1)]
        exact = (ends[0] - ends[1]) / 2.0
        assert np.linalg.norm(row - exact) < 0.01 * np.linalg.norm(exact), name


def test_a_payload_determines_moments_and_stiffness_of_an_outside_robot() -> None:
    fit = refitted(weighed(PAYLOAD))
    assert len(fit.free_names) == 15  # not joint 1's compliance
    truth = {f"joint-compliance.j{k + 1}.c": 1.0 / float(SIX_STIFFNESS[k]) for k in range(6)}
    for place, (mx, my) in zip(PLACES, MOMENTS, strict=True):
        truth |= {f"link-weight.{place.label}.mx": mx, f"link-weight.{place.label}.my": my}
    values = fit.robot.values()
    away = np.array([values[name] - truth[name] for name in fit.free_names])
    assert chi2.sf(float(away @ np.linalg.solve(fit.covariance, away)), len(away)) > 1e-3


def test_without_a_payload_one_common_scale_is_unknown() -> None:
    fit = refitted(weighed(0.0))
    assert not fit.free_names
    (scale,) = [ambiguity for ambiguity in fit.ambiguities if len(ambiguity.names) > 1]
    assert len(scale.names) == 15
    assert scale.names[0].startswith("link-weight.")
    assert scale.cause is Undetermined.COMMON_SCALE
    # where the weight acts is known but for that scale: compliance times whole moment is the true robot's
    chain, values = robot_chain(), fit.robot.values()
    own = np.array([[values[f"link-weight.{place.label}.{symbol}"] for symbol in ("mx", "my")] for place in PLACES])
    whole = [
        weight_about_drives(CompliantRobot(chain, moved(chain, moments)).adjusted_chain) for moments in (own, MOMENTS)
    ]
    compliance = np.array([values[f"joint-compliance.j{k}.c"] for k in range(2, 7)])
    products = compliance[:, None] * whole[0] * SIX_STIFFNESS[1:, None]
    away = np.abs(products - whole[1]).max(axis=1) / np.abs(whole[1]).max(axis=1)
    # 20 µm at a wrist's lever of 0.15 m and sag of 0.3 mrad, 40 poses: 7 % of one pose, 3 % at the farthest
    assert away.max() < 0.1, away


def weight_about_drives(chain: Chain) -> Floats:
    """Return (5, n) torques of the weight about joints 2 to 6, N·m."""
    states = absolute_states(chain, 20, 9)
    inputs = Inputs(chain.model_angles(states.joints).T, np.zeros((6, 20)), states.setup)
    return node_wrenches(chain, deformed_chain(chain, inputs.angles, None), inputs)[3:13:2, RZ]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_torques_at_rest_determine_the_scale(sign: float) -> None:
    """No payload, but what pinocchio's motors hold, each with an error of gain and an offset of its own."""
    pytest.importorskip("pinocchio", reason="pinocchio has no wheel for this platform")
    from tests.laboratory.pinocchio_robot import gravity_torques, pinocchio_model

    gain_sigma, scatter, rng = 0.03, 3.0, np.random.default_rng(8)
    states, chain = weighed(0.0), robot_chain()
    outside = pinocchio_model(true_chain())
    torque = np.array([gravity_torques(outside, q) for q in chain.model_angles(states.joints)])
    torque = torque * (1.0 + gain_sigma * rng.standard_normal(6)) + 2.0 * rng.standard_normal(6)
    torque = sign * (torque + scatter * rng.standard_normal(torque.shape))
    states = replace(states, joint_torque=torque, setup=replace(states.setup, torque_gain_sigma=gain_sigma))
    fit = refitted(states)
    assert len(fit.free_names) == 15
    truth = {f"joint-compliance.j{k + 1}.c": 1.0 / float(SIX_STIFFNESS[k]) for k in range(6)}
    for place, (mx, my) in zip(PLACES, MOMENTS, strict=True):
        truth |= {f"link-weight.{place.label}.mx": mx, f"link-weight.{place.label}.my": my}
    away = np.array([fit.robot.values()[name] - truth[name] for name in fit.free_names])
    assert chi2.sf(float(away @ np.linalg.solve(fit.covariance, away)), len(away)) > 1e-3
    # four motors hold weight: the scale is known to less than one gain, and no better than the mean of all
    second = fit.parameter("joint-compliance.j2.c")
    assert gain_sigma / 3.0 < (second.std or np.inf) / (second.value or np.nan) < gain_sigma
