"""Foundations that give."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    BASE_NODE,
    RX,
    RY,
    Covariate,
    Law,
    NodeLoads,
    Place,
    Term,
    Values,
)
from stiffcal.model.laws.diagonal import CompliantAxis, diagonal_parameters, diagonal_terms

_TURN = CompliantAxis(
    "rotation of the base about its {axis} axis",
    1e-3,
    7e-8,
    "as stiff as joint 1's bearing of a KUKA KR240 (after Rösch): 1/1.4e7; anchored plates are several times softer",
)
_SHIFT = CompliantAxis(
    "translation of the base along its {axis} axis",
    1e-5,
    5e-9,
    "Schneider et al. 2014, section III.C: all translations together below 4e-8",
)


class BaseCompliance(Law):
    """The foundation, the pedestal or the bolts under the robot are compliant.

    Law: δ = diag(tx, ty, tz, rx, ry, rz) w, three rotations over the three moments and three translations over the
    three forces at the base's origin, in base axes. Abele et al. 2008 and Wang, Zhang and Fuhlbrigge 2009, section
    II.A, mention the base as a source of compliance and do not model it.

    Assumes that the six directions do not couple and that the tracker is not on the foundation of the robot.

    Limits: the rotation about z (about joint 1's axis) moves everything exactly as the drive of joint 1 does; only
    their sum is identifiable. Rotations about x and y differ from tilts of joint 1's bearing only in that they stay
    with the base while joint 1 turns.
    """

    name = "base-compliance"
    place_kind = "setup"
    summary = "compliance of the foundation: three rotations, three translations"
    parameters = diagonal_parameters(_TURN, _SHIFT)
    looks_like = ("bearing-tilt", "joint-compliance", "tracker-frame")
    fingerprint = "the whole robot tilts with the moment on its base, about the same base axis at any angle of joint 1"
    how_to_check = "Mount a target or a dial indicator on the robot base and load the tool at full reach."

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """A diagonal compliance at the base's origin."""
        return diagonal_terms(BASE_NODE, loads)

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The tilting moment on the foundation."""
        return Covariate.size_of("tilting moment on the base", "N·m", loads.wrench[BASE_NODE, [RX, RY]])
