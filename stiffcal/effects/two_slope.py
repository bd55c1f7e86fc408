"""Wind-up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
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

_SOURCE = (
    "strain-wave gear catalogues: slope K1 below a torque T1 of tens of N·m for mid sizes, with K1 some 0.6 of K2 of "
    "about 1e5 N·m/rad"
)

# Knees tried: how many, and the first as a multiple of the least torque; where that is none, as a share of the largest,
# which is the narrowest band that backlash tries.
_KNEES, _ABOVE_LEAST, _LEAST_SHARE = 8, 1.5, 3e-3


class TwoSlope(Law):
    """A drive is softer below a wind-up torque, where few teeth or rollers carry the load, than above.

    Law: δ_Rz = c clip(τ, −knee, +knee), added to joint-compliance: the compliance is larger by c below the knee and
    unchanged above it. Manufacturers of strain-wave gears state it in this form, as stiffness K1 up to a torque T1 and
    K2 above.

    Assumes that the knee is sharp, the same in both directions, and without memory; τ is the whole torque.

    Limits: where weight keeps the joint above its knee in every pose and at every load, it is not identifiable. A knee
    far below the smallest load cannot be distinguished from backlash.
    """

    name = "two-slope"
    place_kind = "joints"
    in_drive = True
    summary = "lower stiffness below a wind-up torque than above"
    parameters = (
        ParameterSpec(
            "c",
            "rad/(N·m)",
            "additional compliance below the wind-up torque",
            0.0,
            1e-3,
            6e-6,
            _SOURCE,
            compliance=False,
            meaning_along="additional compliance below the wind-up force",
        ),
        ParameterSpec(
            "knee",
            "N·m",
            "wind-up torque",
            1e-2,
            1e5,
            30.0,
            _SOURCE,
            ParameterRole.NONLINEAR,
            meaning_along="wind-up force",
        ),
    )
    prismatic = specs_along_axis(parameters)
    needs = ("loads of several sizes",)
    looks_like = ("cubic-stiffness", "backlash", "friction-hysteresis")
    fingerprint = (
        "the slope of deflection over torque is larger around zero torque and changes at the same torque on both sides"
    )
    how_to_check = (
        "Load only this joint in small steps through zero torque and find the torque at which the slope changes."
    )

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c clip(τ, ±knee)."""
        joint, knee = place.joints[0], shape["knee"]
        return drive_terms(chain, joint, "c", np.clip(drive_torque(chain, loads.wrench, joint), -knee, knee))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """C clip(τ, ±knee)."""
        return drive_law(chain, place.joints[0], LawForm.CLIPPED, values["c"], values["knee"])

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Knees over the range of the torques applied; none where no torque lies inside the smallest.

        At even ratios, as a knee of a few N·m shows in the few states below it alone; below all torques it is none, as
        only the product with its compliance shows there.
        """
        size = np.abs(drive_torque(chain, loads.wrench, place.joints[0]))
        reach = float(size.max(initial=0.0))
        if reach == 0.0 or size.min() > 0.9 * reach:
            return {"knee": np.zeros(0)}
        low, high = max(_ABOVE_LEAST * float(size.min()), _LEAST_SHARE * reach), float(np.quantile(size, 0.85))
        return {"knee": np.unique(np.clip(np.geomspace(low, max(high, low), _KNEES), 1e-2, 1e5))}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis."""
        return drive_covariate(chain, loads.wrench, place.joints[0])
