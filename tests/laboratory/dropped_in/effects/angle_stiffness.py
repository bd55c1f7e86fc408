"""A joint that gets softer and stiffer as joint 1 turns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.effects_api import RZ, Law, NodeLoads, ParameterSpec, Place, Term, Values, joint_node
from stiffcal.mechanics.chain import Chain


class AngleStiffness(Law):
    """The compliance of a joint follows the sine of 2.3 times the angle of joint 1.

    Law: δ_Rz = c sin(2.3 q1) τ.

    Assumes nothing else.

    Limits: made up.
    """

    name = "angle-stiffness"
    place_kind = "joints"
    summary = "the joint's compliance follows joint 1's angle"
    parameters = (ParameterSpec("c", "rad/(N·m)", "amplitude of the change", -1e-3, 1e-3, 1e-7, "made up for a test"),)
    fingerprint = "the residual is proportional to the joint's torque, with a factor that joint 1's angle sets"
    how_to_check = "Repeat one load on the joint at several angles of joint 1."

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return the turn of the joint."""
        node = joint_node(place.joints[0])
        return (Term(node, RZ, "c", np.sin(2.3 * loads.angles[0]) * loads.wrench[node, RZ]),)
