"""Joints that drag each other along."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Kind,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.laws.drives import drive_covariate, drive_terms, drive_torque


class AxisCoupling(Law):
    """Torque on one joint also rotates another one, because they share shafts, belts, a housing or a control loop.

    Law: δ_a += c τ_b and δ_b += c τ_a, rotations about the two joints' axes over the torques about them; one number for
    both, after Maxwell and Betti. It is the off-diagonal element of the joint compliance matrix, which Wang, Zhang and
    Fuhlbrigge 2009 (section II.A) set to zero.

    Assumes that the coupling is elastic and does not depend on the pose. Hollow-shaft wrists, whose motors sit in the
    arm and drive through one another, couple joints 4, 5 and 6; cables and parallel rods couple 2 and 3.

    Limits: c² may not exceed the product of the two joints' own compliances, otherwise a load would release energy. The
    sign of c is free. Joints whose axes stay parallel (2 and 3 on most robots) couple through torques that are nearly
    the same.
    """

    name = "axis-coupling"
    kind = Kind.COUPLING
    place_kind = "pairs"
    prismatic = "the effect couples turns"
    in_drive = True
    summary = "torque on one joint rotates the other"
    parameters = (
        ParameterSpec(
            symbol="c",
            unit="rad/(N·m)",
            meaning="rotation of either joint per torque on the other",
            lower=-1e-3,
            upper=1e-3,
            typical=1e-6,
            source="at most the geometric mean of the two drives' compliances: Wang, Zhang and Fuhlbrigge 2009, "
            "section III.C: 1.4e-6 (joint 1) to 6e-5 (joint 6)",
        ),
    )
    looks_like = ("joint-compliance", "bearing-tilt", "link-beam")
    fingerprint = "a joint rotates without torque about its axis, in proportion to the torque on another joint"
    how_to_check = (
        "Load the tool with the line of force through one joint axis and at a lever arm to the other; measure the "
        "link of the unloaded joint with a dial indicator."
    )

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_a += c τ_b, δ_b += c τ_a."""
        a, b = place.joints
        return (
            *drive_terms(chain, a, "c", drive_torque(chain, loads.wrench, b)),
            *drive_terms(chain, b, "c", drive_torque(chain, loads.wrench, a)),
        )

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque on the outboard joint, which turns the inboard one at the longer lever."""
        return drive_covariate(chain, loads.wrench, place.joints[1])
