"""Drives that are stiffer one way than the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.laws.drives import drive_covariate, drive_law, drive_terms, drive_torque
from stiffcal.model.laws.prismatic import specs_along_axis
from stiffcal.model.scalar_laws import LawForm, ScalarLaw


class AsymmetricStiffness(Law):
    """The compliance of a drive differs between the two directions of torque.

    Law: δ_Rz = c max(τ, 0), added to joint-compliance: under positive torque (about the joint frame's z axis) the
    compliance is that of joint-compliance plus c, under negative torque that of joint-compliance alone.

    Assumes two straight branches that meet at zero of the whole torque, weight included. Belts, chains, cylinders and
    worn flanks do so; Lehmann et al. 2013 find curves of clamped joints whose two halves differ (Table 2, quadratic
    terms).

    Limits: c may be negative (then positive torque is met more stiffly), as long as the sum with the joint's own
    compliance is not. A joint that weight keeps on one side shows nothing.
    """

    name = "asymmetric-stiffness"
    place_kind = "joints"
    in_drive = True
    summary = "different stiffness for positive and negative torque"
    parameters = (
        ParameterSpec(
            symbol="c",
            unit="rad/(N·m)",
            meaning="extra compliance under positive torque",
            meaning_along="extra compliance under positive force",
            lower=-1e-3,
            upper=1e-3,
            typical=2e-7,
            source="Lehmann et al. 2013, Table 2, KUKA KR125, joint 2: slopes at plus and minus 0.05° differ by a "
            "sixth; a tenth of a drive of 2e-6 (Wang, Zhang and Fuhlbrigge 2009, section III.C)",
        ),
    )
    prismatic = specs_along_axis(parameters)
    needs = ("torque of both signs on the joint",)
    looks_like = ("cubic-stiffness", "backlash", "two-slope")
    fingerprint = "deflection over the joint's torque has a kink at zero torque: two straight lines of different slope"
    how_to_check = "Load only this joint, in both directions, in a pose where weight produces no torque on it."

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c max(τ, 0)."""
        joint = place.joints[0]
        return drive_terms(chain, joint, "c", np.maximum(drive_torque(chain, loads.wrench, joint), 0.0))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """C max(τ, 0)."""
        return drive_law(chain, place.joints[0], LawForm.POSITIVE, values["c"])

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis."""
        return drive_covariate(chain, loads.wrench, place.joints[0])
