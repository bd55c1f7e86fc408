"""What gives between flange and target."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    RX,
    RY,
    Covariate,
    Law,
    NodeLoads,
    Place,
    Term,
    Values,
    tool_node,
)
from stiffcal.model.laws.diagonal import CompliantAxis, diagonal_parameters, diagonal_terms

_TURN = CompliantAxis(
    "rotation about the flange {axis} axis",
    1e-2,
    3e-6,
    "a six-axis force sensor of the 2.5 kN class (ATI Theta, Omega160): some 3e5 N·m/rad",
)
_SHIFT = CompliantAxis(
    "translation along the flange {axis} axis",
    1e-5,
    1e-8,
    "a six-axis force sensor of the 2.5 kN class (ATI Theta, Omega160): some 1e8 N/m",
)


class ToolCompliance(Law):
    """Parts between flange and target are compliant: force sensor, adapter plates, tool changer, probe.

    Law: δ = diag(tx, ty, tz, rx, ry, rz) w, three rotations over the three moments and three translations over the
    three forces at the flange's origin, in flange axes.

    Assumes that load and target are outboard of the compliant part, and that the six directions do not couple.

    Limits: the turn about z moves the tool exactly as the last joint's drive does where that axis passes through the
    flange; only their sum is known. A target before the sensor is not affected.
    """

    name = "tool-compliance"
    place_kind = "setup"
    summary = "compliance between flange and target: three rotations, three translations"
    parameters = diagonal_parameters(_TURN, _SHIFT)
    looks_like = ("joint-compliance", "bearing-tilt", "joint-translation")
    fingerprint = "the deflection of the tool in flange axes is the same in every pose, independent of the joint angles"
    how_to_check = "Mount one target before and one after sensor and adapters, and load the tool."

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """A diagonal compliance at the flange's origin."""
        return diagonal_terms(tool_node(chain), loads)

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The bending moment at the flange."""
        return Covariate.size_of("bending moment at the flange", "N·m", loads.wrench[-1, [RX, RY]])
