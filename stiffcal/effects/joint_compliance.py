"""Elastic drives."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    RZ,
    Covariate,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.laws.drives import drive_covariate, drive_terms, drive_torque
from stiffcal.model.laws.prismatic import specs_along_axis


class JointCompliance(Law):
    """The drive of a joint (gear, shaft, motor's position loop) rotates in proportion to the torque about its axis.

    Law: δ_Rz = c τ, with τ the whole torque about the joint's axis, weight included (Wang, Zhang and Fuhlbrigge 2009,
    eq. 7; c = 1 / k_θ). At a prismatic joint the drive gives along the axis, δ_z = c F, c in m/N.

    Assumes that the drive is linear, without play or friction, and that everything else is rigid. On robots whose axes
    are coupled mechanically the drive sits on the logged axis: it carries τ_drive = Mᵀ τ and turns the model joints by
    M δ (coupling = "mechanical" in robot.toml).

    Limits: holds for torques well above the friction of the gear and well below its limit. Any other rotation of the
    tool about the same axis (base about z, tool about the last axis, a wrist bearing) is included in the same
    parameter.
    """

    name = "joint-compliance"
    place_kind = "joints"
    in_drive = True
    summary = "drive compliance: rotation about the joint axis, proportional to torque"
    parameters = (
        ParameterSpec(
            symbol="c",
            unit="rad/(N·m)",
            meaning="compliance of the drive about the joint's axis",
            meaning_along="compliance of the drive along the joint's axis",
            lower=0.0,
            # Softer than any joint that carries a tool: harmonic drives of light arms have some 1e4 N·m/rad.
            upper=1e-1,
            typical=2e-6,
            source="Wang, Zhang and Fuhlbrigge 2009, section III.C: 1.4e-6 (joint 1) to 6e-5 (joint 6)",
            compliance=True,
            along=RZ,
        ),
    )
    prismatic = specs_along_axis(parameters)
    looks_like = ("base-compliance", "tool-compliance", "bearing-tilt")
    fingerprint = "deflection proportional to load and to the lever arm about the joint axis"
    how_to_check = "Load only this joint, with the force perpendicular to its axis, at two lever arms."

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c τ, at every joint that the drive turns: one, but for mechanically coupled axes."""
        joint = place.joints[0]
        return drive_terms(chain, joint, "c", drive_torque(chain, loads.wrench, joint))

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis."""
        return drive_covariate(chain, loads.wrench, place.joints[0])
