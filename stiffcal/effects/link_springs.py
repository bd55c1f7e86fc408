"""Links as springs half-way along."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    RX,
    RY,
    RZ,
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

_SOURCE = "KUKA KR240, after Rösch: swing 7.7e6, 7.0e6, 1.1e7; arm 3.6e6, 2.9e6, 1.7e7"


class LinkSprings(Law):
    """A link is two rigid halves joined by three rotational springs at its middle.

    Law: θ1 = M1/k1; θ2 = (M2 − F3 L/2)/k2 and u3 = −θ2 L/2; θ3 = (M3 + F2 L/2)/k3 and u2 = θ3 L/2, with F and M the
    wrench at the outboard end and L the length: three springs at mid-length, about the axis along the link (1) and
    across it (2, 3), each over the moment there. This is Rösch's model as “Deformation of Robot Bodies During
    Machining” gives it (section 2 and Table 1, columns S and A).

    Assumes that where the link bends does not matter, only by how much it turns. Compared with a beam it has the
    correct rotation under a pure moment (k = EI/L) but 3/4 of the deflection under a force at the end.

    Limits: as for the beam. The two exclude each other at one link; in most data they cannot be distinguished. Rods on
    such a link read a uniform curvature whose total rotation is that of the springs.
    """

    name = "link-springs"
    place_kind = "links"
    summary = "link as three rotational springs at its middle"
    excludes = ("link-beam",)
    parameters = (
        ParameterSpec("k1", "N·m/rad", "spring about x1, along the link", 1e2, np.inf, 1.1e7, _SOURCE, inverse=True),
        ParameterSpec("k2", "N·m/rad", "spring about x2", 1e2, np.inf, 7.0e6, _SOURCE, inverse=True),
        ParameterSpec("k3", "N·m/rad", "spring about x3", 1e2, np.inf, 7.7e6, _SOURCE, inverse=True),
    )
    looks_like = ("link-beam", "bearing-tilt", "joint-compliance")
    fingerprint = "the tool deflects perpendicular to the link, in proportion to the moment at its middle"
    how_to_check = "As for link-beam: targets on both ends of the link, and a load at the tool."

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Displacement of the outboard end from the moment at mid-length, one amplitude per spring."""
        beam = chain.beams[place.link]
        node, half = link_node(beam.joint), beam.length / 2.0
        _, f2, f3, m1, m2, m3 = loads.wrench[node]
        about_2, about_3 = m2 - half * f3, m3 + half * f2
        return (
            Term(node, RX, "k1", m1),
            Term(node, RY, "k2", about_2),
            Term(node, TZ, "k2", -half * about_2),
            Term(node, RZ, "k3", about_3),
            Term(node, TY, "k3", half * about_3),
        )

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The bending moment at the middle of."""
        beam = chain.beams[place.link]
        _, f2, f3, _, m2, m3 = loads.wrench[link_node(beam.joint)]
        half = beam.length / 2.0
        moment = np.stack([m2 - half * f3, m3 + half * f2])
        return Covariate.size_of(f"bending moment at the middle of {place.link}", "N·m", moment)
