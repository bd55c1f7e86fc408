"""Absolute places whose error follows the directions of last motions in a way that no effect of the catalogue has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.answers.pattern_results import FollowedBy
from stiffcal.diagnosis.remainder.pattern_plugin import plugin_text
from stiffcal.diagnosis.remainder.patterns import find_pattern
from stiffcal.diagnosis.remainder.structure import what_it_follows
from stiffcal.diagnosis.scans.load_scan import scan_candidates
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.effect import Effect, Law, NodeLoads, ParameterSpec, Place, Term, Values
from stiffcal.model.laws.drives import drive_terms, drive_torque
from tests.laboratory.absolute_places import SIGMA, absolute_states
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs


class LoadFriction(Law):
    """Friction in proportion to the load, in the direction from which the joint came."""

    name = "load-friction"
    place_kind = "joints"
    summary = "outside"
    parameters = (ParameterSpec("c", "rad/(N·m)", "size", -1.0, 1.0, 1e-7, "invented"),)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """−c |τ| s."""
        joint = place.joints[0]
        direction = 0.0 if loads.order is None else loads.order.direction(joint)
        return drive_terms(chain, joint, "c", -direction * np.abs(drive_torque(chain, loads.wrench, joint)))


def fitted(directions_known: bool) -> tuple[Fit, LoadStates]:
    """Return the joints' springs fitted to 150 places of a robot with such friction in joint 2, and the states."""
    chain, rng = six_axes(), np.random.default_rng(4)
    states = absolute_states(chain, 150, seed=4)
    states = replace(states, setup=replace(states.setup, estimated=()))
    known = replace(states, approach=rng.choice([-1.0, 1.0], (150, 6)))
    springs = joint_springs(chain)
    hidden = PlacedEffect(LoadFriction(), Place("joints", (2,)), {"c": 5e-8})
    values = {f"joint-compliance.j{k + 1}.c": 1.0 / stiffness for k, stiffness in enumerate(SIX_STIFFNESS)}
    robot = CompliantRobot(chain, (*springs.placed, hidden)).with_values(values)
    rest = solve_balance(
        robot, chain.model_angles(known.joints), known.wrench, known.setup, observe(known, chain).order
    )
    places = rest.target_position + rng.normal(0.0, SIGMA, rest.target_position.shape)
    measured = replace(known if directions_known else states, position=places)
    return identify_parameters(measured, springs), measured


def test_the_compliance_follows_the_last_motion() -> None:
    fit, states = fitted(directions_known=True)
    pattern = find_pattern(fit, states)
    assert pattern is not None
    assert (pattern.joint, pattern.follows, pattern.of_joint) == (2, FollowedBy.LAST_MOTION, 2)
    assert pattern.share > 0.9
    (value,) = pattern.parameters
    assert value.value == pytest.approx(-5e-8, rel=0.05)
    names: dict[str, type[Effect]] = {}
    exec(plugin_text(pattern, "follows-it"), names)
    state = Linearised.about(fit.robot, fit.data)
    written = state.regressor(names["FollowsIt"](), Place("joints", (2,)), {})
    own = state.regressor(LoadFriction(), Place("joints", (2,)), {})
    np.testing.assert_allclose(written.columns, -own.columns, atol=1e-9 * np.abs(own.columns).max())


def test_what_is_left_follows_the_directions_where_they_are_known() -> None:
    fit, states = fitted(directions_known=True)
    families = {family.follows: family.share for family in what_it_follows(scan_candidates(fit, []), states)}
    assert max(families, key=lambda name: families[name] or 0.0) == "approach"
    fit, states = fitted(directions_known=False)
    assert "approach" not in {family.follows for family in what_it_follows(scan_candidates(fit, []), states)}
