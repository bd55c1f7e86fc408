"""Force sensors with a wrong gain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Inputs, Instrument, ParameterRole, ParameterSpec, Place, Values

_SOURCE = "sensors are calibrated to 1 or 2 % of full scale, forces and moments separately"


class WrenchScale(Instrument):
    """The gain of the force sensor is wrong; 1 is correct.

    Law: F_read = g F and M_read = g g_M M, with F and M the true force and moment, g [force] and g_M [moment], the
    gain of the moments against that of the forces.

    Assumes the same gain for all three forces, the same for all three moments, and for the whole campaign.

    Limits: [force] alone is exactly redundant with all compliances: a sensor that reads 2 % too much makes every
    compliance 2 % too small and fits as well. It is known only where a known weight or torque acts in a law that is not
    straight (links' masses known, and play, friction or curved stiffness in the model), and held at 1 or at the model
    file's value elsewhere; so the relative uncertainty of every stiffness is at least that of the gain of the force
    sensor. [moment] needs moments that are no force times one lever: loads in several directions.
    """

    name = "wrench-scale"
    place_kind = "setup"
    summary = "gain error of the force sensor: of the moments relative to the forces, or of both"
    parameters = (
        ParameterSpec(
            "moment", "1", "gain of the moments (measured over true) relative to that of the "
        "forces", 0.5, 2.0, 1.02, _SOURCE,
            ParameterRole.SETUP, neutral=1.0,
        ),
        ParameterSpec(
            "force", "1", "gain of forces and moments (measured over true)", 0.5, 2.0, 1.02, _SOURCE,
            ParameterRole.SETUP, neutral=1.0, scales_load=True,
        ),
    )  # fmt: skip
    needs = ("forces with moments, in several directions",)
    looks_like = ("wrench-origin", "wrench-frame", "tool-compliance")
    fingerprint = "deflections caused by moments are wrong by one factor, those caused by forces are not"
    how_to_check = (
        "Hang a known mass on a hook at a known position: measured force over weight is the gain of the forces, "
        "measured moment over lever arm times weight that of the moments."
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
