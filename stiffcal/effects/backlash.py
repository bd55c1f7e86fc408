"""Lost motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
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
from stiffcal.model.laws.drives import drive_covariate, drive_law, drive_terms, drive_torque
from stiffcal.model.laws.prismatic import specs_along_axis
from stiffcal.model.scalar_laws import LawForm, ScalarLaw

# Bands tried, as shares of the largest torque: from a crossing between two load steps to one over a good part of
# the load.
_BANDS = np.geomspace(3e-3, 0.3, 6)


class Backlash(Law, KnownSlopes):
    """The teeth of a gear have clearance: when the torque changes sign, the joint rotates by the lost motion.

    Law: δ_Rz = (b/2) tanh(τ/w), with b the lost motion between the two flanks (width) and w the band of torque within
    which it is crossed; τ is the whole torque, weight included. Lehmann et al. 2013, section 3.1 and figure 3: theory
    crosses at no torque, real gears within a narrow band, because of friction and teeth that do not all touch at once.

    Assumes that the crossing is the same in both directions; a difference is found as friction-hysteresis in addition.

    Limits: a joint that weight keeps on one flank in every pose and at every load shows no backlash, and its backlash
    is not identifiable. The band is seldom well determined: only the few load states inside it determine it.
    """

    name = "backlash"
    place_kind = "joints"
    in_drive = True
    summary = "lost motion when the total torque, weight included, changes sign"
    parameters = (
        ParameterSpec(
            "width", "rad", "lost motion between the flanks", 0.0, 0.1, 2e-3,
            "Lehmann et al. 2013, Table 2 (KUKA KR125, clamped): 0.10° to 0.16°; new precision gears: 1 arc minute",
        ),
        ParameterSpec(
            "band", "N·m", "torque within which the backlash is crossed", 1e-3, 1e4, 5.0,
            "manufacturers of cycloidal gears state lost motion within ±3 % of the rated torque of some 10² to 10³ N·m",
            ParameterRole.NONLINEAR, meaning_along="force within which the backlash is crossed",
        ),
    )  # fmt: skip
    prismatic = specs_along_axis(parameters)
    needs = ("torque of both signs on the joint",)
    looks_like = ("friction-hysteresis", "two-slope", "asymmetric-stiffness", "cubic-stiffness")
    fingerprint = "the residual jumps where the total torque on the joint changes sign, and is constant on both sides"
    how_to_check = (
        "Move the joint to a pose where weight produces no torque on it, and rock the link by hand with a dial "
        "indicator on it: it moves freely by the backlash."
    )

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = width · tanh(τ/band)/2."""
        joint = place.joints[0]
        torque = drive_torque(chain, loads.wrench, joint)
        return drive_terms(chain, joint, "width", 0.5 * np.tanh(torque / shape["band"]))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """(width/2) tanh(τ/band)."""
        return drive_law(chain, place.joints[0], LawForm.CROSSING, 0.5 * values["width"], values["band"])

    def shape_slopes(self, place: Place, chain: Chain, loads: NodeLoads, values: Values) -> Sequence[Term]:
        """∂δ/∂band = −width τ/(2 band²) sech²(τ/band)."""
        joint, band = place.joints[0], values["band"]
        ratio = drive_torque(chain, loads.wrench, joint) / band
        slope = -0.5 * values["width"] * ratio / band * (1.0 - np.tanh(ratio) ** 2)
        return drive_terms(chain, joint, "band", slope)

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Bands as shares of the largest torque applied; none where the torque keeps its sign."""
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        if torque.size == 0 or float(torque.min()) * float(torque.max()) >= 0.0:
            return {"band": np.zeros(0)}
        return {"band": np.clip(_BANDS * float(np.abs(torque).max()), 1e-3, 1e4)}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis."""
        return drive_covariate(chain, loads.wrench, place.joints[0])
