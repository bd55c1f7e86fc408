"""A beam's section, solved: its stiffnesses, the fibres that matter, and how it warps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers


@dataclass(frozen=True)
class BeamSection:
    """A section of one material; x2 and x3 as in the beam frame, m."""

    area: float
    """m², of the section."""
    EA: float
    """N, axial rigidity."""
    EI2: float
    """N·m², E ∫x3² dA about the neutral fibre."""
    EI3: float
    """N·m², E ∫x2² dA about the neutral fibre."""
    EI23: float
    """N·m², E ∫x2 x3 dA about the neutral fibre."""
    GJ: float
    """Torsional rigidity after Saint-Venant, N·m²."""
    shear_2: float
    """N, shear rigidity for forces along x2; the Euler–Bernoulli beam takes it as infinite."""
    shear_3: float
    """N, shear rigidity for forces along x3; the Euler–Bernoulli beam takes it as infinite."""
    neutral: tuple[float, float]
    """(x2, x3) of the centroid."""
    twist_centre: tuple[float, float]
    """(x2, x3) of the shear centre (Trefftz)."""
    warping_rigidity: float
    """E ∫Ψ² dA, N·m⁴."""
    warping_decay: float | None
    """m, over which warping held back at a clamp decays; None where the section does not warp. From one mode of
    warping: near for open sections, of the right order for closed ones (`tests.benchmarks.solid_link`).
    """
    warping_hold: float
    """Share of the twist that the clamp prevents over that length."""
    nodes: Floats
    """(p, 2) m, nodes of the mesh."""
    triangles: Integers
    """(t, 3) node indices of each triangle."""
    warping: Floats
    """(p,) Ψ about the twist centre, m², without mean and tilt."""

    def shear_share(self, length: float) -> tuple[float, float]:
        """Return the relative share by which shear raises a cantilever's deflection under an end force along x2 and x3.

        3 EI/(GA_s L²); the Euler–Bernoulli beam leaves it out, and no rod along the link can show it.
        """
        return 3.0 * self.EI3 / (self.shear_2 * length**2), 3.0 * self.EI2 / (self.shear_3 * length**2)

    def warping_at(self, points: Floats) -> Floats:
        """Return Ψ at (p, 2) places, m²; outside the section that of the nearest point of it.

        Rods are fixed on the wall or on a bracket, which moves with the wall where it stands.
        """
        corners = self.nodes[self.triangles]
        warping = np.empty(len(points))
        for i, point in enumerate(np.asarray(points, dtype=np.float64)):
            weights = _barycentric(corners, point)
            # The nearest point of each triangle is inside it, or on an edge.
            inside = np.flatnonzero(np.all(weights >= -1e-12, axis=1))
            if len(inside):
                warping[i] = weights[inside[0]] @ self.warping[self.triangles[inside[0]]]
                continue
            warping[i] = self._on_nearest_edge(point)
        return warping

    def _on_nearest_edge(self, point: Floats) -> float:
        edges = np.concatenate([self.triangles[:, [0, 1]], self.triangles[:, [1, 2]], self.triangles[:, [2, 0]]])
        start, end = self.nodes[edges[:, 0]], self.nodes[edges[:, 1]]
        along = end - start
        share = np.clip(np.sum((point - start) * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
        distance = np.linalg.norm(start + share[:, None] * along - point, axis=1)
        nearest = int(np.argmin(distance))
        values = self.warping[edges[nearest]]
        return float(values[0] + share[nearest] * (values[1] - values[0]))


def _barycentric(corners: Floats, point: Floats) -> Floats:
    """Return (t, 3) barycentric coordinates of a point in t triangles (t, 3, 2)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    twice = turn(b - a, c - a)
    first, second = turn(b - point, c - point) / twice, turn(c - point, a - point) / twice
    return np.column_stack([first, second, 1.0 - first - second])


def turn(u: Floats, v: Floats) -> Floats:
    """Return the third component of u × v, for (…, 2) vectors: positive where v lies to the left of u."""
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
