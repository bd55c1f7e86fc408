"""A law whose values are whole numbers, as a plugin may return them, is differentiated like any other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import Sigma
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Law, NodeLoads, ParameterSpec, Place, Term, Values
from stiffcal.model.laws.drives import drive_terms, drive_torque
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played


class RoundedTorque(Law):
    """A drive that turns by whole numbers of its torque."""

    name = "rounded-torque"
    place_kind = "joints"
    parameters = (ParameterSpec("c", "rad/(N·m)", "compliance", -1e-3, 1e-3, 1e-6, "none"),)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return the torque without its decimals."""
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        return drive_terms(chain, place.joints[0], "c", np.rint(torque).astype(np.int64))


def test_values_of_whole_numbers_are_differentiated() -> None:
    states = played(medium_robot(), runs=6, noise=Sigma(16e-6, 30e-6, 0.5, 0.6), load_scatter=0.3, seed=1)
    robot = joint_springs(six_axes())
    placed = PlacedEffect(RoundedTorque(), Place("joints", (4,)), {"c": 1e-6})
    fit = identify_parameters(states, replace(robot, placed=(*robot.placed, placed)))
    assert np.isfinite(fit.residual).all()
