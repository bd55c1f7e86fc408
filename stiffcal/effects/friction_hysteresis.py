"""Friction that lets loading and unloading run apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drives import drive_law, drive_terms, drive_torque
from stiffcal.model.effect import (
    Covariate,
    DocumentedEffect,
    Kind,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.memory import play_operator, play_operator_from_rest
from stiffcal.model.scalar_laws import LawForm, ScalarLaw

# Slips tried, as shares of the largest swing of torque within one run: a slip beyond half the swing never lets go.
_SLIPS = np.geomspace(0.02, 0.45, 7)


class FrictionHysteresis(DocumentedEffect):
    """A part of the drive is held by dry friction: it follows the torque only after this has turned back far enough.

    Law: δ_Rz = c P_r[τ], P_r the play operator: its value stays until it is r (slip) behind the torque, then follows
    at that distance, P_i = min(max(P_{i−1}, τ_i − r), τ_i + r) (Brokate and Sprekels 1996, section 2.3; a spring in
    parallel with a slider, the element of Ruderman, Hoffmann and Bertram 2009). τ is the whole torque, states in the
    order in which they were reached; the memory is zero at the run's start, then the weight acts, then the states.

    Assumes dry friction that does not depend on speed or time, and that all turning points of the load are among the
    load states. Several elements with different slips add up to any symmetric loop; one is fitted.

    Limits: nothing is known of what the joint did before the run; the first half cycle is therefore less certain than
    the later ones. Load that only grows shows no loop.
    """

    name = "friction-hysteresis"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    in_drive = True
    summary = "loading and unloading run on different curves"
    has_memory = True
    parameters = (
        ParameterSpec(
            "c", "rad/(N·m)", "compliance of what slips", 0.0, 1e-1, 1e-6,
            "hysteresis loss of 1 arc minute (2 c slip), the usual limit in catalogues of strain-wave gears",
        ),
        ParameterSpec(
            "slip", "N·m", "torque by which the part stays behind", 1e-2, 1e5, 150.0,
            "as c: 1 arc minute; as the friction torque of a loaded robot joint (Lehmann et al. 2013, section 3.2)",
            ParameterRole.NONLINEAR,
        ),
    )  # fmt: skip
    needs = ("loading and unloading in one run",)
    looks_like = ("backlash", "creep", "two-slope")
    fingerprint = "loading and unloading run on different curves, by the same amount in every cycle, however slowly"
    how_to_check = (
        "Run the load up and down with twice the waiting time: creep would close the loop, friction leaves it as it is."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Runs of a single state have no path."""
        if np.bincount(states.run).max(initial=0) < 3:
            return "loading and unloading in one run: every run has one or two states"
        return None

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c P_r[τ]."""
        joint, slip = place.joints[0], shape["slip"]
        torque = drive_torque(chain, loads.wrench, joint)
        if loads.order is None:
            return drive_terms(chain, joint, "c", play_operator_from_rest(torque, slip))
        start = None if loads.weight is None else drive_torque(chain, loads.weight, joint)
        return drive_terms(chain, joint, "c", play_operator(torque, slip, loads.order.run, start))

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """C P_r[τ]."""
        return drive_law(chain, place.joints[0], LawForm.PLAY, values["c"], values["slip"])

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Slips as shares of the largest swing of torque within one run."""
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        if loads.order is None or torque.size == 0:
            return {"slip": np.zeros(0)}
        _, number = np.unique(loads.order.run, return_inverse=True)
        high, low = np.full(number.max() + 1, -np.inf), np.full(number.max() + 1, np.inf)
        np.maximum.at(high, number, torque)
        np.minimum.at(low, number, torque)
        swing = float((high - low).max())
        return {"slip": np.clip(_SLIPS * swing, 1e-2, 1e5) if swing > 0.0 else np.zeros(0)}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis; the residual runs in loops over it."""
        joint = place.joints[0]
        return Covariate(f"torque on joint {joint}", "N·m", drive_torque(chain, loads.wrench, joint))
