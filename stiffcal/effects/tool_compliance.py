"""What gives between flange and target."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.mechanics.chain import Chain
from stiffcal.model.diagonal import CompliantAxis, diagonal_parameters, diagonal_terms
from stiffcal.model.effect import (
    RX,
    RY,
    Covariate,
    DocumentedEffect,
    Kind,
    NodeLoads,
    Place,
    Term,
    Values,
    tool_node,
)

_TURN = CompliantAxis(
    "turn about the flange's {axis} axis",
    1e-2,
    3e-6,
    "a six-axis force sensor of the 2.5 kN class (ATI Theta, Omega160): some 3e5 N·m/rad",
)
_SHIFT = CompliantAxis(
    "shift along the flange's {axis} axis",
    1e-5,
    1e-8,
    "a six-axis force sensor of the 2.5 kN class (ATI Theta, Omega160): some 1e8 N/m",
)


class ToolCompliance(DocumentedEffect):
    """What is screwed between flange and target gives: force sensor, adapter plates, tool changer, probe.

    Law: δ = diag(tx, ty, tz, rx, ry, rz) w, three rotations over the three moments and three translations over the
    three forces at the flange's origin, in flange axes.

    Assumes that load and target sit outboard of what gives, and that the six directions do not couple.

    Limits: the turn about z moves the tool exactly as the last joint's drive does where that axis passes through the
    flange; only their sum is known. A target that sits before the sensor does not see this at all.
    """

    name = "tool-compliance"
    kind = Kind.NODE_LAW
    place_kind = "setup"
    summary = "what lies between flange and target gives: the same six"
    parameters = diagonal_parameters(_TURN, _SHIFT)
    looks_like = ("joint-compliance", "bearing-tilt", "joint-translation")
    fingerprint = "the tool's deflection in flange axes is the same in every pose, and the robot's joints do not matter"
    how_to_check = "Put one target before and one behind the sensor and the adapters, and load the tool."

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """A diagonal compliance at the flange's origin."""
        return diagonal_terms(tool_node(chain), loads)

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The bending moment at the flange."""
        moment = np.hypot(loads.wrench[-1, RX], loads.wrench[-1, RY])
        return Covariate("bending moment at the flange", "N·m", moment)
