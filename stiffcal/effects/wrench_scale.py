"""Force sensors with a wrong gain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import DocumentedEffect, Inputs, Kind, ParameterRole, ParameterSpec, Place, Values

_SOURCE = "sensors are calibrated to 1 or 2 % of full scale, forces and moments separately"


class WrenchScale(DocumentedEffect):
    """The force sensor reads too much or too little; 1 is right.

    Law: F_read = g F and M_read = g g_M M, with F and M the true force and moment, g [force] and g_M [moment], the
    gain of the moments against that of the forces.

    Assumes gains that are alike for all three forces, for all three moments, and for the whole campaign.

    Limits: [force] alone is exactly redundant with all compliances: a sensor that reads 2 % too much makes every
    compliance 2 % too small and fits as well. It is known only where a known weight or torque acts in a law that is
    not straight (links' masses known, and play, friction or curved stiffness in the model), and held at 1 or at the
    model file's value elsewhere; so every stiffness is known no better than the force sensor's gain. [moment] needs
    moments that are no force times one lever: loads in several directions.
    """

    name = "wrench-scale"
    kind = Kind.OBSERVATION
    place_kind = "setup"
    summary = "the force sensor's gain is wrong: that of the moments against the forces, or of both"
    parameters = (
        ParameterSpec(
            "moment", "1", "moments read over true, against forces read over true", 0.5, 2.0, 1.02, _SOURCE,
            ParameterRole.SETUP, neutral=1.0,
        ),
        ParameterSpec(
            "force", "1", "forces and moments read over true", 0.5, 2.0, 1.02, _SOURCE,
            ParameterRole.SETUP, neutral=1.0, scales_load=True,
        ),
    )  # fmt: skip
    needs = ("forces with moments, in several directions",)
    looks_like = ("wrench-origin", "wrench-frame", "tool-compliance")
    fingerprint = "what turns with the moments is too large or too small by one factor, what turns with the forces not"
    how_to_check = (
        "Hang a known mass on a hook of known place: the force read over its weight is the gain of the forces, the "
        "moment read over lever times weight that of both."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Moments must be read."""
        if not states.setup.moments_measured:
            return "forces with moments: the gain of forces alone is exactly redundant with all compliances"
        return None

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Divide the reading by the gains; the weight-only state has no reading."""
        force, moment = values.get("force", 1.0), values.get("moment", 1.0)
        if not inputs.loaded or (force == 1.0 and moment == 1.0):
            return inputs
        gain = np.repeat([force, force * moment], 3)
        return replace(inputs, wrench=inputs.wrench / gain[:, None])
