"""Bearings that shift."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    TX,
    TY,
    TZ,
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

_SOURCE = "Schneider et al. 2014, section III.C: within the noise of ±90 µm at loads up to 2.5 kN, so below 4e-8"
_AXES = {"tx": (TX, "along the joint frame's x axis"), "ty": (TY, "along its y axis"), "tz": (TZ, "along the axis")}
_COMPONENTS = {symbol: axis for symbol, (axis, _) in _AXES.items()}


class JointTranslation(Law):
    """The bearing of a joint is compliant along the forces that it carries, radially and axially.

    Law: δ_tx = c_tx F_x, δ_ty = c_ty F_y, δ_tz = c_tz F_z, in the joint's frame (the translational part of the joint
    model of Schneider et al. 2014, eq. 1, taken diagonal). At a prismatic joint the two across its axis: along it the
    drive gives. A model that names tx2, tx3, ty2 … (`stiffcal add …
    --curved`) takes all three curved, δ = c F + c2 F² + c3 F³ (Schneider et al. 2014, III.C).

    Assumes pre-loaded rolling bearings in stiff housings.

    Limits: usually small. A kilonewton moves a good bearing by some micrometres; Schneider et al. 2014 found no clear
    trend in the translations of six joints. Expect it to matter only where a bearing or its seat is damaged or loose.
    The forces are nearly the same at all joints, so the place is identifiable only from the orientation of the joint
    axes in different poses.
    """

    name = "joint-translation"
    place_kind = "joints"
    summary = "axial and radial compliance of the bearing"
    parameters = tuple(
        ParameterSpec(symbol, "m/N", f"compliance {meaning}", 0.0, 1e-5, 5e-9, _SOURCE, compliance=True, along=axis)
        for symbol, (axis, meaning) in _AXES.items()
    )
    # what gives along the axis is the drive (joint-compliance)
    prismatic = parameters[:2]
    looks_like = ("base-compliance", "tool-compliance", "joint-translation")
    fingerprint = "the tool moves along the force without rotation, by the same amount for any lever arm"
    how_to_check = (
        "Push the link after the joint along and perpendicular to the axis, with the line of force through the "
        "bearing, and measure against the housing before the bearing with a dial indicator."
    )

    def components(self, place: Place, chain: Chain) -> dict[str, int]:
        """Return symbol to component of the node: all three, at a prismatic joint those across its axis."""
        along = "tz" if place.joints[0] in chain.prismatic_joints else ""
        return {symbol: axis for symbol, axis in _COMPONENTS.items() if symbol != along}

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Three translations over three forces."""
        node, components = joint_node(place.joints[0]), self.components(place, chain)
        return tuple(Term(node, axis, symbol, loads.wrench[node, axis]) for symbol, axis in components.items())

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The force that the bearing carries."""
        force = loads.wrench[joint_node(place.joints[0]), :3]
        return Covariate.size_of(f"force on bearing {place.joints[0]}", "N", force)


class _Curved(JointTranslation):
    __doc__ = JointTranslation.__doc__

    parameters = tuple(
        spec
        for linear in JointTranslation.parameters
        for spec in (linear, *curve_specs(linear, load=1000.0, largest=1e-5))
    )
    prismatic = tuple(spec for spec in parameters if not spec.symbol.startswith("tz"))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ = c F + c2 F² + c3 F³ along all three axes."""
        return curved_terms(place, loads, self.components(place, chain))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """The same polynomials."""
        return curved_laws(place, values, self.components(place, chain))


JointTranslation.forms = (JointTranslation(), _Curved())
