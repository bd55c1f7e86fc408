"""Coupling errors: the same states with the links rigid, all at once, the links' part taken out, and with rods."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.documents import document_of
from stiffcal.identification.answers.coupling import (
    Coupling,
    coupling_result,
    identify_both_ways,
    without_links,
    without_measured_links,
)
from stiffcal.identification.bodies.link_noise import _directions, spread_by_rods
from stiffcal.identification.bodies.link_results import Way
from stiffcal.identification.bodies.measured_links import measure_links
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.identification.readings.observations import observe
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.effect import Place
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.rod_states import (
    NOISE,
    SWING,
    bending_swing,
    five_rods,
    placed,
    swinging_robot,
    with_effect,
    with_rods,
)
from tests.laboratory.simulated_states import joint_springs, played


@pytest.fixture(scope="module")
def robot() -> CompliantRobot:
    return swinging_robot()


@pytest.fixture(scope="module")
def states(robot: CompliantRobot) -> LoadStates:
    return with_rods(played(robot, runs=6, noise=NOISE), robot, five_rods(robot.chain))


@pytest.fixture(scope="module")
def coupling(robot: CompliantRobot, states: LoadStates) -> Coupling:
    return identify_both_ways(states, with_effect(joint_springs(robot.chain), bending_swing()))


@pytest.mark.parametrize("way", ["tool-alone", "links-taken-out", "with-rods"])
def test_joints_come_out_right(coupling: Coupling, way: Way) -> None:
    found = coupling.values(way)
    for joint, stiffness in enumerate(SIX_STIFFNESS, start=1):
        value, std = found[f"joint-compliance.j{joint}.c"]
        assert abs(value - 1.0 / stiffness) < 4.0 * std, (joint, value * stiffness)


def test_rigid_links_make_them_wrong(coupling: Coupling) -> None:
    found = coupling.values("links-rigid")
    off = [(found[f"joint-compliance.j{j}.c"][0] * k - 1.0) for j, k in enumerate(SIX_STIFFNESS, start=1)]
    assert max(np.abs(off)) > 0.1


def test_a_twist_that_the_rods_do_not_see_stays_a_parameter(coupling: Coupling) -> None:
    taken_out = coupling.values("links-taken-out")
    value, std = taken_out["link-beam.swing.GJ"]
    assert abs(value - SWING["GJ"]) < 4.0 * std < 2.0 * SWING["GJ"]
    assert "link-beam.swing.EI2" not in taken_out


def test_what_is_taken_out_is_the_links_part(robot: CompliantRobot, states: LoadStates) -> None:
    rigid = CompliantRobot(robot.chain, ())
    freed = without_links(states, robot.chain, measure_links(observe(states, robot.chain), rigid))
    stiff = with_effect(joint_springs(robot.chain, SIX_STIFFNESS), bending_swing(GJ=SWING["GJ"]))
    joints = robot.chain.model_angles(states.joints)
    truth = solve_balance(stiff, joints, states.wrench, states.setup).displacement[:, 0, :3]
    first = np.searchsorted(states.run, states.run)
    left = (freed.position - freed.position[first])[:, 0] - (truth - truth[first])
    # what is left is the readings' own noise, twice, and some per cent of the link's share by second order
    assert np.sqrt(np.mean(left**2)) < 2.0 * 10e-6
    assert freed.lengths.shape[1] == 0


def test_the_document_is_json(coupling: Coupling) -> None:
    document = document_of(coupling_result(coupling))
    json.dumps(document, allow_nan=False)
    ways = {way["way"]: way for way in document["ways"]}
    assert "link-beam.swing.EI2" in ways["links-rigid"]["left_out"]
    assert "link-beam.swing.EI2" in ways["links-taken-out"]["left_out"]
    assert "link-beam.swing.GJ" not in ways["links-taken-out"]["left_out"]


def test_springs_half_way_are_taken_out_likewise(robot: CompliantRobot, states: LoadStates) -> None:
    springs = placed("link-springs", Place("links", (), "swing"))
    coupling = identify_both_ways(states, with_effect(joint_springs(robot.chain), springs))
    assert "link-springs.swing.k1" in coupling.values("links-taken-out")
    assert "link-springs.swing.k2" not in coupling.values("links-taken-out")


def test_the_rods_noise_goes_into_the_joints_uncertainty(robot: CompliantRobot) -> None:
    """A tool read without noise, rods with 5 µm: what is wrong with the joints is the rods' doing, and is stated."""
    exact = played(robot, runs=6)
    exact = replace(exact, setup=replace(exact.setup, sigma=Sigma(translation=1e-6, rotation=2e-6)))
    rigid = CompliantRobot(robot.chain, ())
    off = []
    for seed in range(6):
        states = with_rods(exact, robot, five_rods(robot.chain, sigma=5e-6), seed=seed)
        observed = observe(states, robot.chain)
        links = measure_links(observed, rigid)
        rest, held = without_measured_links(with_effect(joint_springs(robot.chain), bending_swing()), links)
        fit = identify_parameters(without_links(states, robot.chain, links), rest, Settings(fixed=held))
        spread = spread_by_rods(fit, links, observed)
        for joint, stiffness in enumerate(SIX_STIFFNESS, start=1):
            one = fit.parameter(f"joint-compliance.j{joint}.c")
            assert one.value is not None
            off.append((one.value - 1.0 / stiffness) / spread[one.name])
    # five numbers of the swing, six times: 30 degrees of freedom, within three standard deviations
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(1.0, abs=3.0 / np.sqrt(60.0))


def test_directions_of_a_links_error_add_up_to_its_uncertainty(robot: CompliantRobot, states: LoadStates) -> None:
    """Independent errors of the compliance: the sum of their squares is each element's variance."""
    (link,) = measure_links(observe(states, robot.chain), CompliantRobot(robot.chain, ()))
    variance = np.sum(_directions(link.compliance) ** 2, axis=0)
    known = np.isfinite(link.compliance.matrix)
    np.testing.assert_allclose(np.sqrt(variance[known]), link.compliance.std[known], rtol=1e-9)
