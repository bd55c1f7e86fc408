"""Motors that are pushed off."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Kind,
    Law,
    NodeLoads,
    Place,
    Term,
    Values,
    joint_node,
)

# A fifth of an arc second: below any motor encoder's step behind its gear, above a printed angle's last digit.
_STANDS_STILL = 1e-6


class ServoDeflection(Law):
    """The motor deviates from its target under load, because the stiffness of its position loop is finite.

    Law: D = … + J Δq_motor: the joints turn by what the motors' encoders show since the run's reference, besides the
    give of everything behind the encoder (physics, section 1). There is no free parameter: the controller's log gives
    it all. Wang, Zhang and Fuhlbrigge 2009, section II.A, count this active stiffness of the position loop into the
    joint's.

    Assumes that the log holds measured joint positions of every state, not the commanded ones, and that the controller
    was not moving the robot to compensate the deflection.

    Limits: without it in the model the loop's give counts as the joint's compliance, which is then right for this
    controller in this state, and no longer for the mechanics alone.
    """

    name = "servo-deflection"
    kind = Kind.CONFIGURATION
    place_kind = "joints"
    prismatic = ()
    summary = "deviation of the motor position under load, visible in the controller log"
    needs = ("measured joint positions of every state",)
    looks_like = ("joint-compliance", "creep", "friction-hysteresis")
    fingerprint = "the logged joint position moves with the load, and the tool moves with it"
    how_to_check = (
        "Read the joint position on the controller while the load is applied: it moves, and returns slowly if the "
        "position loop has integral action."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """The joint log must move within runs."""
        largest_motion = 0.0
        for members in members_of(states.run):
            largest_motion = max(largest_motion, float(np.ptp(states.joints[members], axis=0).max()))
        if largest_motion < _STANDS_STILL:
            return "measured joint positions of every state: the joint log is constant within every run"
        return None

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = Δq_motor, nothing in the weight-only state."""
        if loads.order is None:
            return ()
        joint = place.joints[0]
        return (Term(joint_node(joint), int(chain.drive_components[joint - 1]), "", loads.order.motor[joint - 1]),)

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """The motor's motion since the reference."""
        if loads.order is None:
            return None
        joint = place.joints[0]
        unit = "m" if joint in chain.prismatic_joints else "rad"
        return Covariate(f"motion of motor {joint}", unit, loads.order.motor[joint - 1])
