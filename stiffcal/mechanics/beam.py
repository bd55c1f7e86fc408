"""The displacement field of a link as a cantilever beam: paper 000, eq. 1–5.

Along the beam run the fibre's displacements ū1, ū2, ū3 and the twist φ1; φ2 = −ū3′, φ3 = ū2′ (eq. 2 and 3), κ = φ1′
(eq. 5). A material point at (x1, x2, x3) moves by (eq. 4)

    u = (ū1 − x2 φ3 + x3 φ2 + Ψ κ,  ū2 − x3 φ1,  ū3 + x2 φ1),

x2 and x3 counted from the neutral fibre in the first component and from the twist centre in the others. The inboard
end is clamped. What a wrench at the outboard end can make of such a beam are six fields, one cubic polynomial and its
kin: tension, torsion, and for each plane a tip force and a tip moment. They determine the six displacements of the
outboard end, and are determined by them: that is why everything linear here is written per displacement of the end.

Why the twist is not a cubic too: with warping free it grows evenly (κ constant, as in the paper); with warping held
back at the clamp it follows cosh((L − x1)/d), d the decay length. For d far above L that is the cubic x1² (3L − x1).
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.rods import BeamProperties

# The unknowns in the order in which rods are spent on them (physics, section 6): one for each degree of freedom, then
# a tip moment for each plane. "2" is bending along x2 (about x3), "3" bending along x3 (about x2).
UNKNOWNS = ("tip force 2", "tip force 3", "tension", "torsion", "tip moment 2", "tip moment 3")
FORCE_2, FORCE_3, TENSION, TORSION, MOMENT_2, MOMENT_3 = range(6)
# Fields that no wrench at the end makes, to see what they would do to an estimate.
OTHER_FIELDS = ("even load 2", "even load 3")

# Rows of a field: displacements and turns of the fibre, and the warping's amplitude.
_U1, _U2, _U3, _PHI1, _PHI2, _PHI3, _CHI = range(7)


def fibre_fields(beam: BeamProperties, x1: Floats) -> Floats:
    """Return (8, 7, p): the unknowns' fields and `OTHER_FIELDS` along the beam.

    Rows are ū1, ū2, ū3, φ1, φ2, φ3 and the warping's amplitude χ (κ where warping is free). Amplitudes: the curvature
    at the clamp (force, moment, even load), 1/m; the strain (tension); the twist far from the clamp (torsion), rad/m.
    Inboard of the clamp nothing moves; outboard of the end the link goes on rigidly.

    Parameters
    ----------
    beam : its length, neutral fibre, twist centre and warping.
    x1 : (p,) places along it, m.
    """
    length = beam.length
    x = np.clip(x1, 0.0, length)
    beyond = np.maximum(x1 - length, 0.0)
    fields = np.zeros((len(UNKNOWNS) + len(OTHER_FIELDS), 7, len(x)))
    fields[TENSION, _U1] = x
    fields[TORSION, _PHI1], fields[TORSION, _CHI] = _twist(beam, x)
    bends = (
        (FORCE_2, FORCE_3, x**2 / 2.0 - x**3 / (6.0 * length), x - x**2 / (2.0 * length)),
        (MOMENT_2, MOMENT_3, x**2 / 2.0, x),
        (
            len(UNKNOWNS), len(UNKNOWNS) + 1,
            x**2 / 2.0 - x**3 / (3.0 * length) + x**4 / (12.0 * length**2),
            x - x**2 / length + x**3 / (3.0 * length**2),
        ),
    )  # fmt: skip
    for along_2, along_3, bend, slope in bends:
        fields[along_2, _U2] = bend + slope * beyond
        fields[along_2, _PHI3] = slope
        fields[along_3, _U3] = bend + slope * beyond
        fields[along_3, _PHI2] = -slope
    fields[:, _CHI, x1 < 0.0] = 0.0
    return fields


def _twist(beam: BeamProperties, x: Floats) -> tuple[Floats, Floats]:
    """Return twist angle and warping amplitude per unit of twist far from the clamp.

    With warping held at x = 0 and free at L, EΓ χ″ = (GJ/(1 − GJ/GIp)) (χ − κ) gives χ = 1 − cosh((L−x)/d)/cosh(L/d)
    and φ1′ = 1 − hold (1 − χ) (Vlasov for hold = 1; Benscoter, J. Appl. Mech. 21 (1954) 25, else).
    """
    if beam.warping_decay is None:
        return x, np.ones_like(x)
    decay, length = beam.warping_decay, beam.length
    # cosh((L−x)/d)/cosh(L/d) and its integral, by exponentials that cannot overflow
    down, up = np.exp(-x / decay), np.exp(-(2.0 * length - x) / decay)
    denominator = 1.0 + np.exp(-2.0 * length / decay)
    hyperbolic_ratio = (down + up) / denominator
    area = decay * ((1.0 - np.exp(-2.0 * length / decay)) - (down - up)) / denominator
    return x - beam.warping_hold * area, 1.0 - hyperbolic_ratio


def fields_at_points(beam: BeamProperties, points: Floats, warping: Floats) -> Floats:
    """Return (8, p, 3): displacement of material points by the unit fields, beam axes (eq. 4).

    Parameters
    ----------
    points : (p, 3) beam frame, m.
    warping : (p,) the warping function there, m²; NaN counts as zero.
    """
    fields = fibre_fields(beam, points[:, 0])
    (n2, n3), (c2, c3) = beam.neutral, beam.twist_centre
    x2, x3 = points[:, 1], points[:, 2]
    displacement = np.empty((len(fields), len(points), 3))
    displacement[:, :, 0] = (
        fields[:, _U1]
        - (x2 - n2) * fields[:, _PHI3]
        + (x3 - n3) * fields[:, _PHI2]
        + np.nan_to_num(warping) * fields[:, _CHI]
    )
    displacement[:, :, 1] = fields[:, _U2] - (x3 - c3) * fields[:, _PHI1]
    displacement[:, :, 2] = fields[:, _U3] + (x2 - c2) * fields[:, _PHI1]
    return displacement


def end_fields(beam: BeamProperties) -> Floats:
    """Return (6, 8): displacement of the beam axis' outboard end by the unit fields, without warping, m and rad.

    Warping is left out: it is no motion of the section as a whole (Ψ has no mean and no tilt).
    """
    return np.asarray(axis_fields(beam, np.array([beam.length]))[:, :, 0].T)


def axis_fields(beam: BeamProperties, x1: Floats) -> Floats:
    """Return (8, 6, p): displacements and turns of the beam axis by the unit fields."""
    points = np.column_stack([x1, np.zeros_like(x1), np.zeros_like(x1)])
    displacement = fields_at_points(beam, points, np.zeros(len(x1)))
    rotation = fibre_fields(beam, x1)[:, _PHI1 : _PHI3 + 1]
    return np.concatenate([np.moveaxis(displacement, 2, 1), rotation], axis=1)


def amplitudes_from_end_displacement(beam: BeamProperties) -> Floats:
    """Return (6, 6): the amplitude of each unknown (rows) per unit displacement of the outboard end (columns).

    Columns are displacements per m along x1, x2, x3 and turns per rad about them; units of the amplitudes as in
    `fibre_fields`: 1/m, without unit (tension), rad/m (torsion). The inverse of `end_fields` for the six unknowns.
    """
    return np.asarray(np.linalg.inv(end_fields(beam)[:, : len(UNKNOWNS)]))


def material_displacement(beam: BeamProperties, tip: Floats, points: Floats, warping: Floats | None = None) -> Floats:
    """Return the displacement of material points when the outboard end has moved by ``tip`` (eq. 4).

    Parameters
    ----------
    beam : its length, neutral fibre, twist centre and warping.
    tip : (n, 6) displacement of the outboard end, beam axes, m and rad.
    points : (p, 3) beam frame, m.
    warping : (p,) m², zero where left out.

    Returns
    -------
    (n, p, 3) m, beam axes.

    Examples
    --------
    A link of 1 m bent by a force at its end: half-way along it has moved 5/16 as far as there.

    >>> shape = BeamProperties(length=1.0)
    >>> tip = np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 1.5]])
    >>> material_displacement(shape, tip, np.array([[0.5, 0.0, 0.0]]))[0, 0].round(12).tolist()
    [0.0, 0.3125, 0.0]
    """
    added_warping = np.zeros(len(points)) if warping is None else warping
    unit = fields_at_points(beam, points, added_warping)[: len(UNKNOWNS)]
    return np.asarray(np.einsum("ni,ui,upc->npc", tip, amplitudes_from_end_displacement(beam), unit))


def axis_displacement(beam: BeamProperties, tip: Floats, x1: Floats) -> Floats:
    """Return (n, p, 6): displacements and turns along the beam axis when the outboard end has moved by ``tip``."""
    unit = axis_fields(beam, x1)[: len(UNKNOWNS)]
    return np.asarray(np.einsum("ni,ui,ucp->npc", tip, amplitudes_from_end_displacement(beam), unit))


def beam_compliance(
    beam: BeamProperties, bending: tuple[float, float], torsion: float, tension: float, product: float = 0.0
) -> Floats:
    """Return the 6×6 compliance of the end of an Euler–Bernoulli cantilever, beam axes about the beam axis' end.

    Parameters
    ----------
    beam : its length, neutral fibre, twist centre and warping.
    bending : EI2 = E ∫x3² dA (about x2) and EI3 = E ∫x2² dA (about x3), N·m².
    torsion : GJ, N·m².
    tension : EA, N.
    product : EI23 = E ∫x2 x3 dA, N·m²; zero where x2 and x3 are the section's principal axes.

    Returns
    -------
    (6, 6) m and rad per N and N·m, symmetric (Maxwell and Betti).
    """
    about_2, about_3 = bending
    curved = np.linalg.inv([[about_3, product], [product, about_2]])
    flexible = np.zeros((len(UNKNOWNS), len(UNKNOWNS)))
    flexible[TENSION, TENSION], flexible[TORSION, TORSION] = 1.0 / tension, 1.0 / torsion
    for pair in ((FORCE_2, FORCE_3), (MOMENT_2, MOMENT_3)):
        flexible[np.ix_(pair, pair)] = curved
    return np.asarray(end_fields(beam)[:, : len(UNKNOWNS)] @ flexible @ amplitudes_per_load(beam))


def amplitudes_per_load(beam: BeamProperties) -> Floats:
    """Return (6, 6): the unknowns' amplitudes times their rigidity, per unit of the wrench at the axis' end.

    A force along x1 off the neutral fibre bends too, one across it off the twist centre twists too.
    """
    (n2, n3), (c2, c3), length = beam.neutral, beam.twist_centre, beam.length
    rows = np.zeros((6, 6))
    rows[TENSION, 0] = 1.0
    # Moments about the neutral fibre and about the twist centre; columns are F1 F2 F3 M1 M2 M3.
    rows[TORSION] = [0.0, c3, -c2, 1.0, 0.0, 0.0]
    rows[FORCE_2, 1], rows[FORCE_3, 2] = length, length
    rows[MOMENT_2] = [n2, 0.0, 0.0, 0.0, 0.0, 1.0]
    rows[MOMENT_3] = [n3, 0.0, 0.0, 0.0, -1.0, 0.0]
    return rows


def flexibility_patterns(beam: BeamProperties) -> Floats:
    """Return (5, 6, 6): the unknowns' amplitudes per wrench at the axis' end, for each flexibility of an even beam.

    In order: the elements 33, 22 and 23 of the inverse of the bending rigidities, 1/GJ, 1/EA. With x2 and x3 principal
    axes the first two are 1/EI3 and 1/EI2.
    """
    pairs = (
        ((FORCE_2, FORCE_2), (MOMENT_2, MOMENT_2)),
        ((FORCE_3, FORCE_3), (MOMENT_3, MOMENT_3)),
        ((FORCE_2, FORCE_3), (FORCE_3, FORCE_2), (MOMENT_2, MOMENT_3), (MOMENT_3, MOMENT_2)),
        ((TORSION, TORSION),),
        ((TENSION, TENSION),),
    )
    flexible = np.zeros((len(pairs), len(UNKNOWNS), len(UNKNOWNS)))
    for number, places in enumerate(pairs):
        for row, column in places:
            flexible[number, row, column] = 1.0
    return np.asarray(flexible @ amplitudes_per_load(beam))
