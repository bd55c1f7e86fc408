"""Curved torque–angle lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.abilities import KnownSlopes
from stiffcal.model.effect import (
    Covariate,
    Law,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.forms import TorqueCurve
from stiffcal.model.laws.cubic_curve import LEAST_SLOPE, angle_of_torque, monotonic_range
from stiffcal.model.laws.drives import drive_covariate, drive_law, drive_terms, drive_torque
from stiffcal.model.laws.prismatic import specs_along_axis
from stiffcal.model.scalar_laws import LawForm, ScalarLaw

_SOURCE = (
    "Lehmann et al. 2013, Table 2, joint 2 of a KUKA KR125 (−42.5 φ³ − 5.30 φ² + 6.35 φ, 10³ N·m over degrees), "
    "inverted"
)
_CLAMPED = "Lehmann et al. 2013, Table 2: 2·10⁴ to 6·10⁶ N·m over degrees at the flanks of a KUKA KR125's joints, in SI"


class CubicStiffness(Law):
    """The torque–angle characteristic of the drive is curved: it hardens or softens smoothly as the torque grows.

    Law: δ_Rz = c2 τ² + c3 τ³, added to the linear c τ of joint-compliance; the load form of the third-order polynomial
    τ = p1 φ + p2 φ² + p3 φ³ that Lehmann et al. 2013 (section 5.2 and Table 2) fit to clamped joints: c = 1/p1, c2 =
    −p2/p1³, c3 = (2 p2² − p1 p3)/p1⁵ to third order. τ is the whole torque, weight included. Clamped runs give p1, p2
    and p3 themselves; a model that gives these instead takes the curve as it is, φ(τ), its linear term included.

    Assumes one smooth curve for loading and unloading. c3 below zero means hardening, above zero softening; c2 makes
    the two directions of torque different.

    Limits: a polynomial is valid only within the measured torques. The sum c + 2 c2 τ + 3 c3 τ² must stay positive
    there. Weight acts as an offset on the curve: where it keeps the torque within a narrow range, the curve looks
    straight.
    """

    name = "cubic-stiffness"
    place_kind = "joints"
    in_drive = True
    summary = "torque–angle curve with quadratic and cubic terms"
    parameters: ClassVar[tuple[ParameterSpec, ...]] = (
        ParameterSpec(
            "c2",
            "rad/(N·m)²",
            "quadratic term of angle over torque",
            -1e-3,
            1e-3,
            4e-10,
            _SOURCE,
            meaning_along="quadratic term of position over force",
        ),
        ParameterSpec(
            "c3",
            "rad/(N·m)³",
            "cubic term of angle over torque",
            -1e-3,
            1e-3,
            5e-13,
            _SOURCE,
            meaning_along="cubic term of position over force",
        ),
    )
    prismatic = specs_along_axis(parameters)
    needs = ("loads of several sizes",)
    looks_like = ("two-slope", "asymmetric-stiffness", "backlash")
    fingerprint = "the residual is a smooth nonlinear function of the joint torque, the same for loading and unloading"
    how_to_check = (
        "Load only this joint up to twice the usual load, in both directions: the slope changes continuously with "
        "torque."
    )

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c2 τ² + c3 τ³."""
        joint = place.joints[0]
        torque = drive_torque(chain, loads.wrench, joint)
        return (*drive_terms(chain, joint, "c2", torque**2), *drive_terms(chain, joint, "c3", torque**3))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """c2 τ² + c3 τ³."""
        return drive_law(chain, place.joints[0], LawForm.POLYNOMIAL, 0.0, values["c2"], values["c3"])

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis."""
        return drive_covariate(chain, loads.wrench, place.joints[0])


class _TorqueOverAngle(CubicStiffness, TorqueCurve, KnownSlopes):
    __doc__ = CubicStiffness.__doc__

    includes = ("joint-compliance",)
    parameters = (
        ParameterSpec(
            "p1",
            "N·m/rad",
            "slope of torque over angle at the flank",
            0.0,
            1e10,
            4e5,
            _CLAMPED,
            ParameterRole.NONLINEAR,
            meaning_along="slope of force over position at the flank",
        ),
        ParameterSpec(
            "p2",
            "N·m/rad²",
            "quadratic term of torque over angle",
            -1e14,
            1e14,
            0.0,
            _CLAMPED,
            ParameterRole.NONLINEAR,
            meaning_along="quadratic term of force over position",
        ),
        ParameterSpec(
            "p3",
            "N·m/rad³",
            "cubic term of torque over angle",
            -1e18,
            1e18,
            0.0,
            _CLAMPED,
            ParameterRole.NONLINEAR,
            meaning_along="cubic term of force over position",
        ),
    )
    prismatic = specs_along_axis(parameters)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = φ(τ), the inverse of p1 φ + p2 φ² + p3 φ³."""
        joint = place.joints[0]
        torque = drive_torque(chain, loads.wrench, joint)
        return drive_terms(chain, joint, "", angle_of_torque(torque, (shape["p1"], shape["p2"], shape["p3"])))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """The cubic p1 φ + p2 φ² + p3 φ³ = τ."""
        return drive_law(chain, place.joints[0], LawForm.CUBIC_TORQUE, values["p1"], values["p2"], values["p3"])

    def shape_slopes(self, place: Place, chain: Chain, loads: NodeLoads, values: Values) -> Sequence[Term]:
        """∂φ/∂p_k = −φᵏ/(p1 + 2 p2 φ + 3 p3 φ²)."""
        joint, curve = place.joints[0], (values["p1"], values["p2"], values["p3"])
        angle = angle_of_torque(drive_torque(chain, loads.wrench, joint), curve)
        inside = np.clip(angle, *monotonic_range(curve))
        slope = np.maximum(curve[0] + inside * (2.0 * curve[1] + inside * 3.0 * curve[2]), LEAST_SLOPE * curve[0])
        powers = enumerate((inside, inside**2, inside**3), start=1)
        return tuple(term for k, power in powers for term in drive_terms(chain, joint, f"p{k}", -power / slope))

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Clamped drives (Lehmann et al. 2013): elsewhere loads seldom reach the bend."""
        return None if len(states) and states.clamped.all() else "clamped runs, and no others"

    def start(self, torque: Floats, angle: Floats) -> dict[str, float]:
        """Return the cubic of the torque over the angle by least squares."""
        reach = float(np.abs(angle).max(initial=0.0)) or 1.0
        powers = (angle[:, None] / reach) ** np.arange(1, 4)
        p1, p2, p3 = np.linalg.lstsq(powers, torque, rcond=None)[0] / reach ** np.arange(1, 4)
        if p1 > 0.0:
            return {"p1": float(p1), "p2": float(p2), "p3": float(p3)}
        return {"p1": float(torque @ torque / (torque @ angle)), "p2": 0.0, "p3": 0.0}


CubicStiffness.forms = (CubicStiffness(), _TorqueOverAngle())
