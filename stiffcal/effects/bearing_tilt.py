"""Bearings that tilt."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    RX,
    RY,
    Covariate,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
    joint_node,
)
from stiffcal.model.laws.curved import curve_specs, curved_laws, curved_terms
from stiffcal.model.scalar_laws import ScalarLaw

_SOURCE = "KUKA KR240, after Rösch: 1/1.5e7 (joint 2) to 1/3.7e6 (joint 6)"
_AXES = {"x": RX, "y": RY}


class BearingTilt(Law):
    """The main bearing of a joint tilts under moments perpendicular to the joint axis.

    Law: δ_Rx = c_x M_x and δ_Ry = c_y M_y, about the x and y axes of the joint's frame, with M the moment that the
    bearing carries about its centre (the joint's node: the frame's origin, moved by bearing_m along the axis). Abele et
    al. 2008; “Deformation of Robot Bodies During Machining”, Table 1, lists the stiffnesses, the inverses, as c_alpha
    and c_beta. A model that names x2, x3, y2 or y3 (`stiffcal add … --curved`) takes both directions curved, δ = c M +
    c2 M² + c3 M³ (Schneider et al. 2014, III.C).

    Assumes a bearing that is pre-loaded, so that it tilts in proportion, and that its two directions do not couple. A
    bearing's tilt is of the same order as the compliance of its gear and cannot be measured at the motor.

    Limits: the tilts of wrist bearings about the next joint's axis rotate the tool exactly as that joint's drive does;
    only their sum is identifiable. Tilts of neighbouring joints with nearly parallel directions are hard to
    distinguish.
    """

    name = "bearing-tilt"
    place_kind = "joints"
    summary = "rotation about the two axes perpendicular to the joint axis"
    parameters: ClassVar[tuple[ParameterSpec, ...]] = (
        ParameterSpec(
            "x", "rad/(N·m)", "tilt compliance about the joint frame's x axis", 0.0, 1e-3, 1.4e-7, _SOURCE,
            compliance=True, along=RX,
        ),
        ParameterSpec(
            "y", "rad/(N·m)", "tilt compliance about the joint frame's y axis", 0.0, 1e-3, 1.4e-7, _SOURCE,
            compliance=True, along=RY,
        ),
    )  # fmt: skip
    # the carriage tilts on its guides
    prismatic = parameters
    looks_like = ("link-beam", "link-springs", "joint-compliance", "base-compliance")
    fingerprint = (
        "the tool deflects out of the plane of the joint's motion, in proportion to the moment perpendicular to the "
        "joint axis; the joint angle does not change"
    )
    how_to_check = (
        "Load the link next to the joint sideways, parallel to the joint axis, with a dial indicator between the "
        "housings on both sides of the bearing: the gap opens on one side."
    )

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rx = c_x M_x, δ_Ry = c_y M_y."""
        node = joint_node(place.joints[0])
        return (Term(node, RX, "x", loads.wrench[node, RX]), Term(node, RY, "y", loads.wrench[node, RY]))

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The moment across the joint's axis."""
        node = joint_node(place.joints[0])
        label = f"tilting moment on joint {place.joints[0]}"
        return Covariate.size_of(label, "N·m", loads.wrench[node, [RX, RY]])


class _Curved(BearingTilt):
    __doc__ = BearingTilt.__doc__

    parameters = tuple(
        spec for linear in BearingTilt.parameters for spec in (linear, *curve_specs(linear, load=1000.0, largest=1e-3))
    )
    prismatic = parameters

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ = c M + c2 M² + c3 M³ about both axes."""
        return curved_terms(place, loads, _AXES)

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """The same polynomials."""
        return curved_laws(place, values, _AXES)


BearingTilt.forms = (BearingTilt(), _Curved())
