"""The link as a solid: 3D finite elements against the beam's field, its drawn section and its rods.

    python -m tests.benchmarks.solid_link

A box girder (the swing of campaigns/max100), clamped at one end, loaded at the other, in hexahedra of second order
(scikit-fem): what the beam says of its end and of rods on its walls, and how much twist the clamp takes away.

Measured once (21 168 unknowns, 12 s): the end within 0.7 % for tension, torsion and moments; under forces 14.2 % and
12.4 % more than the beam says, of which shear is 14.3 % and 14.2 %; rods along the walls within 0.2 % under moments and
tension, 1.1 % under forces. A rod from one wall to the next sees shear too (25 to 42 % of what it reads under forces)
and Poisson's contraction (2 %). The clamp takes away the twist of 9.3 mm; one mode of warping says 2.7 mm.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.mechanics.beam import beam_compliance
from stiffcal.mechanics.rods import rod_matrix
from stiffcal.mechanics.section_mesh import inner_outline
from stiffcal.mechanics.section_solver import solve_section

WIDTH, HEIGHT, WALL, LENGTH = 0.22, 0.20, 0.008, 0.95
YOUNG, SHEAR = 72e9, 27e9
LOADS = ("tension", "force 2", "force 3", "torsion", "moment 2", "moment 3")


def outline() -> Floats:
    return np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * [WIDTH / 2.0, HEIGHT / 2.0]


def box(around: int = 6, along: int = 24) -> Any:
    """Return the box as hexahedra: `around` on each wall, one through it, finer towards the clamp and the edges."""
    import skfem

    graded = 0.5 * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, around + 1)))
    turn = np.concatenate([wall + graded[:-1] for wall in range(4)] + [[4.0]])
    places = LENGTH * np.linspace(0.0, 1.0, along + 1) ** 1.6
    mesh = skfem.MeshHex.init_tensor(turn, np.array([0.0, 1.0]), places)
    corners = np.vstack([outline(), outline()[:1]])
    inner = inner_outline(outline(), WALL)
    hollow = np.vstack([inner, inner[:1]])
    wall = np.minimum(mesh.p[0].astype(int), 3)
    share = mesh.p[0] - wall
    outside = corners[wall] + share[:, None] * (corners[wall + 1] - corners[wall])
    inside = hollow[wall] + share[:, None] * (hollow[wall + 1] - hollow[wall])
    across = inside + mesh.p[1][:, None] * (outside - inside)
    points = np.column_stack([mesh.p[2], across])
    distinct, numbers = np.unique(np.round(points, 10), axis=0, return_inverse=True)
    return skfem.MeshHex(np.ascontiguousarray(distinct.T), numbers.reshape(-1)[mesh.t])


class Solid:
    """The clamped box and its answers to tractions at its end."""

    def __init__(self) -> None:
        import skfem
        from scipy.sparse.linalg import splu
        from skfem.models.elasticity import linear_elasticity

        self.mesh = box()
        self.element = skfem.ElementVector(skfem.ElementHex2())
        self.basis = skfem.Basis(self.mesh, self.element, intorder=4)
        lame = YOUNG - 2.0 * SHEAR, SHEAR
        second = lame[1] * (YOUNG - 2.0 * SHEAR) / (3.0 * SHEAR - YOUNG)
        matrix = linear_elasticity(second, SHEAR).assemble(self.basis)
        clamped = self.basis.get_dofs(lambda x: x[0] < 1e-9).all()
        self.free = np.setdiff1d(np.arange(self.basis.N), clamped)
        self.factor = splu(matrix[self.free][:, self.free].tocsc())
        facets = self.mesh.facets_satisfying(lambda x: x[0] > LENGTH - 1e-9)
        self.end = skfem.FacetBasis(self.mesh, self.element, facets=facets, intorder=4)
        self.skfem = skfem

    def solve(self, traction: Any) -> Floats:
        load = self.skfem.LinearForm(lambda v, w: sum(t * v[i] for i, t in enumerate(traction(w.x)))).assemble(self.end)
        moved = np.zeros(self.basis.N)
        moved[self.free] = self.factor.solve(load[self.free])
        return moved

    def end_displacement(self, moved: Floats) -> Floats:
        """Return the end section's mean displacement and turn: least squares over its area."""
        x, weight = self.end.global_coordinates(), self.end.dx
        u = np.asarray(self.end.interpolate(moved))
        y, z = np.asarray(x)[1], np.asarray(x)[2]
        area = weight.sum()
        mean = [float((u[i] * weight).sum() / area) for i in range(3)]
        polar = ((y**2 + z**2) * weight).sum()
        twist = float(((u[2] * y - u[1] * z) * weight).sum() / polar)
        about_2 = float((u[0] * z * weight).sum() / (z**2 * weight).sum())
        about_3 = float(-(u[0] * y * weight).sum() / (y**2 * weight).sum())
        return np.array([*mean, twist, about_2, about_3])

    def at(self, moved: Floats, points: Floats) -> Floats:
        """Return (p, 3) displacement of mesh nodes nearest to points."""
        found = []
        for point in points:
            node = int(np.argmin(np.linalg.norm(self.mesh.p.T - point, axis=1)))
            assert np.linalg.norm(self.mesh.p[:, node] - point) < 1e-6, point
            found.append(moved[self.basis.nodal_dofs[:, node]])
        return np.array(found)


def tractions() -> dict[str, Any]:
    """Return unit loads as tractions that leave the section's shape alone: each wall is loaded along itself."""
    area = WIDTH * HEIGHT - (WIDTH - 2 * WALL) * (HEIGHT - 2 * WALL)
    about_3 = (HEIGHT * WIDTH**3 - (HEIGHT - 2 * WALL) * (WIDTH - 2 * WALL) ** 3) / 12.0
    about_2 = (WIDTH * HEIGHT**3 - (WIDTH - 2 * WALL) * (HEIGHT - 2 * WALL) ** 3) / 12.0
    flow = 1.0 / (2.0 * (WIDTH - WALL) * (HEIGHT - WALL) * WALL)  # Bredt

    def across(x: Any) -> tuple[Any, Any]:
        """1 where the wall runs along x2, and where it runs along x3, with the side's sign."""
        y, z = x[1] / (WIDTH / 2 - WALL), x[2] / (HEIGHT / 2 - WALL)
        flat = (np.abs(z) >= 1.0) & (np.abs(y) < 1.0)
        upright = (np.abs(y) >= 1.0) & (np.abs(z) < 1.0)
        return flat * np.sign(z), upright * np.sign(y)

    webs_2, webs_3 = 2.0 * (WIDTH - 2 * WALL) * WALL, 2.0 * (HEIGHT - 2 * WALL) * WALL
    # the corners carry no traction: the flow makes up for their share of the torque
    flow *= 2.0 * (WIDTH - WALL) * (HEIGHT - WALL) / (
        (WIDTH - 2 * WALL) * (HEIGHT - WALL) + (HEIGHT - 2 * WALL) * (WIDTH - WALL)
    )  # fmt: skip
    return {
        "tension": lambda x: (1.0 / area + 0.0 * x[0], 0.0 * x[0], 0.0 * x[0]),
        "force 2": lambda x: (0.0 * x[0], np.abs(across(x)[0]) / webs_2, 0.0 * x[0]),
        "force 3": lambda x: (0.0 * x[0], 0.0 * x[0], np.abs(across(x)[1]) / webs_3),
        "torsion": lambda x: (0.0 * x[0], -flow * across(x)[0], flow * across(x)[1]),
        "moment 2": lambda x: (x[2] / about_2, 0.0 * x[0], 0.0 * x[0]),
        "moment 3": lambda x: (-x[1] / about_3, 0.0 * x[0], 0.0 * x[0]),
    }


def main() -> None:
    solid = Solid()
    section = solve_section(outline(), [inner_outline(outline(), WALL)], YOUNG, SHEAR)
    shape = BeamProperties(LENGTH, section.neutral, section.twist_centre, section.warping_decay, section.warping_hold)
    compliance = beam_compliance(shape, (section.EI2, section.EI3), section.GJ, section.EA)
    shear = section.shear_share(LENGTH)
    stations = np.unique(solid.mesh.p[0])
    near, far = stations[np.argmin(np.abs(stations - 0.15))], stations[np.argmin(np.abs(stations - 0.75))]
    walls = np.array([[WIDTH / 2, 0.0], [-WIDTH / 2, 0.0], [0.0, HEIGHT / 2], [WIDTH / 2, HEIGHT / 2]])
    start, end = (np.column_stack([np.full(4, x), walls]) for x in (near, far))
    start, end = np.vstack([start, [near, *walls[0]]]), np.vstack([end, [far, *walls[2]]])
    warping = np.column_stack([section.warping_at(start[:, 1:]), section.warping_at(end[:, 1:])])
    rods = Rods("swing", ("+x2", "-x2", "+x3", "corner", "oblique"), start, end, warping, np.full(5, np.nan))
    matrix = rod_matrix(rods, shape)
    print(f"{solid.basis.N} unknowns; rods from {near:.3f} to {far:.3f} m of {LENGTH} m; shear adds", shear)
    for number, (load, traction) in enumerate(tractions().items()):
        moved = solid.solve(traction)
        tip, beam = solid.end_displacement(moved), compliance[:, number]
        main_part = number
        along = (end - start) / rods.length[:, None]
        read = np.sum((solid.at(moved, end) - solid.at(moved, start)) * along, axis=1)
        said = matrix @ beam
        seen = np.abs(said) > 0.3 * np.abs(said).max()
        off = ", ".join(f"{rods.names[i]} {100 * (read[i] / said[i] - 1.0):+.2f} %" for i in np.flatnonzero(seen))
        extra = shear[number - 1] if number in (1, 2) else 0.0
        print(
            f"{load:9s} end {100 * (tip[main_part] / beam[main_part] - 1):+6.2f} % (shear {100 * extra:.2f} %), "
            f"rods: {off}"
        )
    _decay(solid, section.warping_hold * (section.warping_decay or 0.0))


def _decay(solid: Solid, stated: float) -> None:
    """Print how fast what the clamp holds back of the warping decays, from the twist that it takes away.

    Far from the clamp the twist grows evenly; its line meets zero at hold × decay from the clamp.
    """
    moved = solid.solve(tractions()["torsion"])
    stations = np.unique(solid.mesh.p[0])
    middle = np.array([[x, 0.0, HEIGHT / 2] for x in stations])
    twist = -solid.at(moved, middle)[:, 1] / (HEIGHT / 2)
    far = (stations > 0.3 * LENGTH) & (stations < 0.8 * LENGTH)
    slope, start = np.polyfit(stations[far], twist[far], 1)
    print(f"the clamp takes away the twist of {-1e3 * start / slope:.2f} mm; by the section {1e3 * stated:.2f} mm")


if __name__ == "__main__":
    main()
