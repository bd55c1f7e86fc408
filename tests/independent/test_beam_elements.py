"""The link's displacement field, its end and its rods against beam finite elements that are not ours.

PyNite (3D frames, Saint-Venant torsion) for bending, tension and even torsion; scikit-fem's elements for torsion with
warping held at the clamp, by its energy. A rod is taken from the elements' nodes by rigid sections: u + θ × arm.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.rods import BeamProperties, Rods, rods_between
from stiffcal.mechanics.beam import axis_displacement, beam_compliance, material_displacement
from stiffcal.mechanics.rods import rod_matrix

LENGTH, NODES = 1.05, 21
E, G = 1.7e11, 6.6e10
AREA, ABOUT_2, ABOUT_3, TWIST = 6.5e-3, 3.1e-5, 5.2e-5, 4.4e-5
ALONG = np.linspace(0.0, LENGTH, NODES)
# Physics asks for 0.1 %; what is left is the elements' own rounding.
AGREE = 1e-6

LOADS = {"FX": 0, "FY": 1, "FZ": 2, "MX": 3, "MY": 4, "MZ": 5}


def rods_on_nodes() -> Rods:
    """Five rods along the fibre, of two lengths, and one across: ends on the elements' nodes."""
    low, near, far = ALONG[1], ALONG[12], ALONG[17]
    start = [[low, 0.1, 0.0], [low, 0.02, 0.09], [low, 0.02, -0.09], [low, -0.1, 0.05], [low, -0.1, -0.05]]
    end = [[far, 0.1, 0.0], [far, 0.02, 0.09], [far, 0.02, -0.09], [near, -0.1, 0.05], [near, -0.1, -0.05]]
    return rods_between("swing", np.array([*start, [low, 0.1, 0.05]]), np.array([*end, [far, -0.1, 0.05]]))


def by_elements(load: str, size: float) -> Floats:
    """Return (NODES, 6): displacements and turns of the nodes under one load at the end."""
    from Pynite import FEModel3D

    model: Any = FEModel3D()
    model.add_material("iron", E, G, 0.3, 0.0)
    model.add_section("swing", AREA, ABOUT_2, ABOUT_3, TWIST)
    for i, x in enumerate(ALONG):
        model.add_node(f"n{i}", float(x), 0.0, 0.0)
    for i in range(NODES - 1):
        model.add_member(f"m{i}", f"n{i}", f"n{i + 1}", "iron", "swing")
    model.def_support("n0", *[True] * 6)
    model.add_node_load(f"n{NODES - 1}", load, size)
    model.analyze_linear()
    nodes = [model.nodes[f"n{i}"] for i in range(NODES)]
    return np.array([[getattr(node, key)["Combo 1"] for key in ("DX", "DY", "DZ", "RX", "RY", "RZ")] for node in nodes])


def carried(nodes: Floats, point: Floats) -> Floats:
    """Return (3,) how a material point moves with the section of its node."""
    section = nodes[np.argmin(np.abs(ALONG - point[0]))]
    return np.asarray(section[:3] + np.cross(section[3:], [0.0, point[1], point[2]]))


@pytest.mark.parametrize("load", list(LOADS))
def test_field_end_and_rods(load: str) -> None:
    size = 1e-6 * E  # the elements' own rounding is absolute
    nodes = by_elements(load, size)
    shape = BeamProperties(LENGTH)
    compliance = beam_compliance(shape, (E * ABOUT_2, E * ABOUT_3), G * TWIST, E * AREA)
    tip = compliance[:, LOADS[load]] * size
    scale = np.abs(nodes).max()
    np.testing.assert_allclose(tip, nodes[-1], rtol=AGREE, atol=AGREE * scale)
    np.testing.assert_allclose(axis_displacement(shape, tip[None], ALONG)[0], nodes, rtol=AGREE, atol=AGREE * scale)
    rods = rods_on_nodes()
    read = np.array(
        [
            (carried(nodes, e) - carried(nodes, b)) @ (e - b) / np.linalg.norm(e - b)
            for b, e in zip(rods.start, rods.end, strict=True)
        ]
    )
    np.testing.assert_allclose(rod_matrix(rods, shape) @ tip, read, rtol=1e-5, atol=1e-6 * np.abs(read).max())


def held_twist(decay: float, hold: float) -> tuple[Floats, Floats]:
    """Return twist (rad) and warping amplitude (rad/m) along the beam under a unit of M/GJ, by finite elements.

    Energy of the clamped bar, u1 = Ψ χ: ½ ∫ EΓ χ'² + G (Ip φ'² − 2 D φ' χ + D χ²), D = hold Ip, J = Ip − D (Benscoter).
    """
    import skfem

    mesh = skfem.MeshLine(np.linspace(0.0, LENGTH, 801))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementLineP2(), 2))
    polar = 1.0 / (1.0 - hold)  # of J = 1, G = 1
    spread, gamma = hold * polar, decay**2 * hold

    def energy(u: Any, v: Any, w: Any) -> Any:
        du, dv = u.grad[:, 0], v.grad[:, 0]
        shear = polar * du[0] * dv[0] - spread * (du[0] * v[1] + u[1] * dv[0]) + spread * u[1] * v[1]
        return gamma * du[1] * dv[1] + shear

    load = np.zeros(basis.N)
    load[basis.get_dofs(lambda x: np.isclose(x[0], LENGTH)).all("u^1")] = 1.0
    solved = skfem.solve(
        *skfem.condense(skfem.BilinearForm(energy).assemble(basis), load, D=basis.get_dofs(lambda x: x[0] < 1e-9))
    )
    return np.interp(ALONG, mesh.p[0], solved[basis.nodal_dofs[0]]), np.interp(
        ALONG, mesh.p[0], solved[basis.nodal_dofs[1]]
    )


@pytest.mark.parametrize(("decay", "hold"), [(0.05, 0.3), (0.4, 0.9995), (3.0, 0.9995)])
def test_torsion_with_warping_held_at_the_clamp(decay: float, hold: float) -> None:
    twist, amplitude = held_twist(decay, hold)
    shape = BeamProperties(LENGTH, warping_decay=decay, warping_hold=hold)
    tip = np.array([[0.0, 0.0, 0.0, twist[-1], 0.0, 0.0]])
    np.testing.assert_allclose(beam_compliance(shape, (1.0, 1.0), 1.0, 1.0)[3, 3], twist[-1], rtol=1e-5)
    np.testing.assert_allclose(axis_displacement(shape, tip, ALONG)[0, :, 3], twist, atol=1e-5 * twist[-1])
    points = np.column_stack([ALONG, np.full(NODES, 0.1), np.full(NODES, 0.08)])
    moved = material_displacement(shape, tip, points, np.full(NODES, 2e-3))[0]
    # the elements' χ at the clamp is known to the mesh's resolution of the decay
    np.testing.assert_allclose(moved[:, 0], 2e-3 * amplitude, atol=2e-5 * 2e-3 * amplitude[-1])


def test_a_long_decay_is_the_cubic_with_a_clamped_end() -> None:
    shape = BeamProperties(LENGTH, warping_decay=200.0 * LENGTH)
    turned = axis_displacement(shape, np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]]), ALONG)[0, :, 3]
    np.testing.assert_allclose(turned, ALONG**2 * (3.0 * LENGTH - ALONG) / (2.0 * LENGTH**3), atol=1e-4)
