"""Properties of a drawn section by finite elements: stiffnesses, shear centre, warping.

Saint-Venant torsion: ∇²ω = 0 with ∂ω/∂n = x3 n2 − x2 n3; J = ∫(x2² + x3²) dA − ∫|∇ω|² dA; the shear centre after
Trefftz makes Ψ = ω − c3 x2 + c2 x3 free of tilt (Pilkey, Analysis and Design of Elastic Beams, ch. 5 and 6). Warping
held back at a clamp: u1 = Ψ χ(x1) with χ free of φ1′ (Benscoter 1954), which holds for closed and open sections alike.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.extras import install_command
from stiffcal.mechanics.section import BeamSection
from stiffcal.mechanics.section_mesh import SectionError, section_mesh, signed_area

if TYPE_CHECKING:
    from collections.abc import Sequence


# Round re-entrant corners the stress is singular: this many halvings towards them leave an error of 1e-5 in J.
CORNER_HALVINGS = 6
# Triangles of a full section, and pieces of the edges of a very thin-walled one.
ELEMENTS, LONGEST = 400, 4000
# A section whose warping carries less of the torsion than this does not warp (circles).
NO_WARPING = 1e-6


class MissingSolverError(ImportError):
    """The extra `section` is not installed.

    Attributes
    ----------
    needs, install : what needs which library, and the command that installs it.
    """

    def __init__(self, needs: str, install: str) -> None:
        super().__init__(f"{needs}: {install}")
        self.needs, self.install = needs, install


def solve_section(
    outline: Floats | Sequence[Sequence[float]],
    holes: Sequence[Floats | Sequence[Sequence[float]]] = (),
    young: float = 1.0,
    shear: float = 1.0,
) -> BeamSection:
    """Solve a drawn section.

    Parameters
    ----------
    outline : (k, 2) corners in order, m.
    holes : the same for each hollow.
    young, shear : moduli E and G, Pa.

    Raises
    ------
    MissingSolverError : scikit-fem is not installed.
    SectionError : the drawing is no section.
    """
    try:
        import skfem
    except ImportError as error:
        raise MissingSolverError("drawn sections need scikit-fem", install_command("section")) from error
    loops = [np.asarray(loop, dtype=np.float64) for loop in (outline, *holes)]
    area = abs(signed_area(loops[0])) - sum(abs(signed_area(hole)) for hole in loops[1:])
    edge = sum(float(np.sum(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))) for loop in loops)
    if area <= 1e-12 * edge**2:
        raise SectionError("the outline encloses nothing")
    # Area over perimeter is half the wall of a thin-walled section; a full one is cut into some hundreds.
    size = max(min(area / edge, np.sqrt(area / ELEMENTS)), edge / LONGEST)
    nodes, triangles = section_mesh(loops, size)
    mesh = _refined(skfem.MeshTri(np.ascontiguousarray(nodes.T), np.ascontiguousarray(triangles.T)), loops)
    return _solve(skfem, mesh, young, shear)


def _refined(mesh: Any, loops: list[Floats]) -> Any:
    corners = np.concatenate([_re_entrant(loop, hole=number > 0) for number, loop in enumerate(loops)])
    for _ in range(CORNER_HALVINGS if len(corners) else 0):
        distance = np.linalg.norm(mesh.p.T[:, None, :] - corners[None], axis=2).min(axis=1)
        at_corner = np.flatnonzero(distance < 1e-9)
        mesh = mesh.refined(np.flatnonzero(np.isin(mesh.t, at_corner).any(axis=0)))
    return mesh


def _re_entrant(loop: Floats, *, hole: bool) -> Floats:
    """Return the corners at which the material fills more than half a turn."""
    before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    turn_angle = np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], np.sum(before * after, axis=1))
    left_turn = turn_angle if signed_area(loop) > 0.0 else -turn_angle
    # Gentle bends of a rounded outline are no singularity worth the elements.
    return np.asarray(loop[left_turn > 0.3] if hole else loop[left_turn < -0.3])


def _solve(skfem: Any, mesh: Any, young: float, shear: float) -> BeamSection:
    from skfem.helpers import dot, grad

    basis = skfem.Basis(mesh, skfem.ElementTriP2(), intorder=6)
    stiffness = skfem.BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis)
    mass = skfem.BilinearForm(lambda u, v, w: u * v).assemble(basis)
    twist = skfem.LinearForm(lambda v, w: w.x[1] * grad(v)[0] - w.x[0] * grad(v)[1]).assemble(basis)
    ones, (x2, x3) = np.ones(basis.N), basis.doflocs
    area = float(ones @ mass @ ones)
    centre = np.array([ones @ mass @ x2, ones @ mass @ x3]) / area
    y, z = x2 - centre[0], x3 - centre[1]
    second_2, second_3, product = float(z @ mass @ z), float(y @ mass @ y), float(y @ mass @ z)

    def potential(load: Floats) -> Floats:
        """Solve ∇² = −load with free edges; what is left open, a constant, is taken out."""
        solved = skfem.solve(*skfem.condense(stiffness, load, D=np.array([0])))
        return np.asarray(solved - ones @ mass @ solved / area)

    omega = potential(twist)
    polar = float(x2 @ mass @ x2 + x3 @ mass @ x3)
    torsion = polar - float(omega @ stiffness @ omega)
    # No mean and no tilt: (c2, c3) about the origin, ω being taken about it.
    matrix = np.array([[product, -second_3], [second_2, -product]])
    pole = np.linalg.solve(matrix, -np.array([omega @ mass @ y, omega @ mass @ z]))
    warping = omega - pole[1] * x2 + pole[0] * x3
    warping = warping - ones @ mass @ warping / area
    gamma, slope = float(warping @ mass @ warping), float(warping @ stiffness @ warping)
    about_pole = second_2 + second_3 + area * float(np.sum((centre - pole) ** 2))
    hold = slope / about_pole
    decay = None if hold < NO_WARPING else float(np.sqrt(young * gamma / (shear * torsion) / hold))
    # Shear by forces along x2 and x3 (ν left out): G ∇²ψ = −F x/I, its energy F²/(2 G A_s).
    inertia = np.array([[second_3, product], [product, second_2]])
    flows = [potential(mass @ (np.linalg.solve(inertia, unit) @ np.stack([y, z]))) for unit in np.eye(2)]
    shears = [shear / float(flow @ stiffness @ flow) for flow in flows]
    vertices = basis.nodal_dofs[0]
    return BeamSection(
        area=area, EA=young * area, EI2=young * second_2, EI3=young * second_3, EI23=young * product,
        GJ=shear * torsion, shear_2=shears[0], shear_3=shears[1],
        neutral=(float(centre[0]), float(centre[1])), twist_centre=(float(pole[0]), float(pole[1])),
        warping_rigidity=young * gamma, warping_decay=decay, warping_hold=hold if decay is not None else 1.0,
        nodes=np.ascontiguousarray(mesh.p.T), triangles=np.ascontiguousarray(mesh.t.T.astype(np.int64)),
        warping=np.asarray(warping[vertices]),
    )  # fmt: skip
