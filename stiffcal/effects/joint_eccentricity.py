"""Encoders and gears that run out of round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.absolute_places_needed import lacks_absolute_places
from stiffcal.model.effect import (
    RZ,
    Covariate,
    Geometry,
    Inputs,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
    joint_node,
)

_SOURCE = "an encoder disc off its centre by 10 µm at a radius of 50 mm: 0.2 mrad"
_ORDERS = (1, 2)
# A sine through fewer poses a period than this goes through anything.
_POSES_A_PERIOD = 3


class JointEccentricity(Geometry):
    """The joint's true angle differs from the logged one by a sine of the angle: an eccentric encoder or gear.

    Law: θ = q + a cos mq + b sin mq, with q the model angle as logged and m the order: 1 and 2, and the gear orders
    that robot.toml gives for the joint.

    Assumes that the error depends on the joint's own angle alone, not on load or direction of motion.

    Limits: the constant part is the joint's zero and belongs to the geometry. If the range of a joint is less than half
    a revolution, order 1 can barely be separated from the zero and a scale. A joint's compliance under weight alone
    follows a sine of order 1 of its angle too: the two differ only where other joints, or a payload, change the torque
    at one angle.
    """

    name = "joint-eccentricity"
    place_kind = "joints"
    prismatic = "it has no angle"
    summary = "the true angle of the joint differs from the logged one by a sine"
    parameters = (
        ParameterSpec("a", "rad", "cosine part of the error", -0.05, 0.05, 2e-4, _SOURCE, tolerance=5e-3),
        ParameterSpec("b", "rad", "sine part of the error", -0.05, 0.05, 2e-4, _SOURCE, tolerance=5e-3),
        ParameterSpec(
            "order", "1", "waves per revolution of the joint", 1.0, 1e4, 1.0,
            "1 and 2 for encoders, else the gear orders in robot.toml",
            ParameterRole.NONLINEAR, discrete=True,
        ),
    )  # fmt: skip
    needs = ("absolute poses at many angles of the joint",)
    looks_like = ("joint-compliance", "joint-offset", "link-geometry")
    fingerprint = (
        "the position error is the lever arm about one joint axis times a sine of its angle, independent of load"
    )
    how_to_check = "Turn the joint alone through its range, unloaded, and compare with an encoder or an index table."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Displacements do not depend on it to first order; a sine needs three poses a period."""
        missing = lacks_absolute_places(states)
        if missing is not None:
            return missing
        n_poses = len(np.unique(np.round(np.degrees(states.joints)), axis=0))
        return None if n_poses >= _POSES_A_PERIOD + 1 else "absolute poses in four poses or more"

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Add the sine to the joint's model angle."""
        a, b, order = values.get("a", 0.0), values.get("b", 0.0), values.get("order", 1.0)
        if not (a or b):
            return inputs
        angles = inputs.angles.copy()
        phase = order * angles[place.joints[0] - 1]
        angles[place.joints[0] - 1] += a * np.cos(phase) + b * np.sin(phase)
        return replace(inputs, angles=angles)

    def geometry_terms(self, place: Place, chain: Chain, angles: Floats, shape: Values) -> Sequence[Term]:
        """Turns about the joint's axis by the cosine and the sine of the angle."""
        node, phase = joint_node(place.joints[0]), shape["order"] * angles[place.joints[0] - 1]
        return [Term(node, RZ, "a", np.cos(phase)), Term(node, RZ, "b", np.sin(phase))]

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Orders 1 and 2, and those gear orders that the poses sample."""
        angle = loads.angles[place.joints[0] - 1]
        turns = float(np.ptp(angle)) / (2.0 * np.pi) if angle.size else 0.0
        n_angles = len(np.unique(np.round(np.degrees(angle))))
        gears = [m for m in chain.gear_orders[place.joints[0] - 1] if n_angles >= _POSES_A_PERIOD * m * turns]
        return {"order": np.array(sorted({*_ORDERS, *gears}), dtype=np.float64)}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The joint's angle."""
        joint = place.joints[0]
        return Covariate(f"angle of joint {joint}", "rad", loads.angles[joint - 1])
