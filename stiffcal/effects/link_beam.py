"""Links that bend."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    RX,
    RY,
    RZ,
    TX,
    TY,
    TZ,
    Covariate,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
    link_node,
)

_BENDING = "KUKA KR240, swing, after Rösch: 7.0e6 to 7.7e6 N·m/rad across, times some 1.2 m from joint 2 to joint 3"


class LinkBeam(Law):
    """A link bends in two planes, twists and stretches, as an Euler–Bernoulli cantilever clamped at its inboard joint.

    Law: u1 = F1 L/EA; θ1 = M1 L/GJ; u2 = F2 L³/(3 EI3) + M3 L²/(2 EI3) and θ3 = F2 L²/(2 EI3) + M3 L/EI3; u3 = F3
    L³/(3 EI2) − M2 L²/(2 EI2) and θ2 = −F3 L²/(2 EI2) + M2 L/EI2, with F and M the force and moment at the outboard
    end in beam axes (x1 along the beam) and L its length (Gross, Hauger, Schröder and Wall, Engineering Mechanics 2,
    table 4.3; signs as in “Deformation of Robot Bodies During Machining”, eq. 2 and 3: φ3 = u2′, φ2 = −u3′).

    Assumes a straight, uniform, slender link of linear material: no shear, free warping. What is outboard of the link
    bends it; its own weight, which acts between its ends, does not. EI2 is bending about x2 (deflection along x3), EI3
    bending about x3, which lies along the inboard joint's axis.

    Limits: bending about x3 of a link between two parallel joints is similar to the compliance of these joints; twist
    is similar to the tilt of a bearing. Tension is as a rule far below what can be measured. Links shorter than 50 mm
    are no place.
    """

    name = "link-beam"
    place_kind = "links"
    summary = "link as a beam: bending in two planes, torsion, tension"
    excludes = ("link-springs",)
    parameters = (
        ParameterSpec("EI2", "N·m²", "flexural rigidity about x2", 1e2, np.inf, 8e6, _BENDING, inverse=True),
        ParameterSpec("EI3", "N·m²", "flexural rigidity about x3", 1e2, np.inf, 8e6, _BENDING, inverse=True),
        ParameterSpec(
            "GJ", "N·m²", "torsional rigidity", 1e2, np.inf, 1.3e7,
            "KUKA KR240, swing, after Rösch: 1.1e7 N·m/rad, times some 1.2 m", inverse=True,
        ),
        ParameterSpec(
            "EA", "N", "rigidity in tension", 1e5, np.inf, 2e9,
            "cast iron, 1.1e11 Pa, times a section of some 0.02 m²", inverse=True,
        ),
    )  # fmt: skip
    looks_like = ("link-springs", "bearing-tilt", "joint-compliance")
    fingerprint = (
        "the tool deflects perpendicular to the link, in proportion to its bending moment; the outboard end of the "
        "link rotates and moves relative to its inboard end"
    )
    how_to_check = (
        "Mount targets on both ends of the link (or integral deformation sensors along it) and load the tool: the "
        "ends rotate relative to each other."
    )

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Displacement of the outboard end from the wrench there, one amplitude per rigidity."""
        beam = chain.beams[place.link]
        node, length = link_node(beam.joint), beam.length
        f1, f2, f3, m1, m2, m3 = loads.wrench[node]
        square, cube = length * length / 2.0, length**3 / 3.0
        return (
            Term(node, TX, "EA", length * f1),
            Term(node, RX, "GJ", length * m1),
            Term(node, TY, "EI3", cube * f2 + square * m3),
            Term(node, RZ, "EI3", square * f2 + length * m3),
            Term(node, TZ, "EI2", cube * f3 - square * m2),
            Term(node, RY, "EI2", length * m2 - square * f3),
        )

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The larger bending moment, at the clamped end."""
        return Covariate.size_of(f"bending moment in {place.link}", "N·m", _clamped_bending(chain, place.link, loads))


def _clamped_bending(chain: Chain, link: str, loads: NodeLoads) -> Floats:
    beam = chain.beams[link]
    _, f2, f3, _, m2, m3 = loads.wrench[link_node(beam.joint)]
    return np.stack([m2 - beam.length * f3, m3 + beam.length * f2])
