"""From the rods back to the link's end: exact where the shape can carry the load, with an interval that holds."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.links.rods import Torsion, bounded_by_load, estimate_link, rod_design, shape_errors
from stiffcal.measurements.rods import BeamProperties, Rods, rods_between
from stiffcal.mechanics.beam import UNKNOWNS, axis_fields, beam_compliance, end_fields
from stiffcal.mechanics.rods import rod_fields, rod_matrix
from stiffcal.mechanics.section_mesh import inner_outline
from stiffcal.mechanics.section_solver import solve_section

LENGTH = 1.05
SHAPE = BeamProperties(LENGTH)
DRAWN = BeamProperties(LENGTH, neutral=(0.01, -0.004), twist_centre=(0.02, 0.003), warping_decay=0.12, warping_hold=0.6)


def paper_rods(sigma: float = np.nan) -> Rods:
    """Five rods along the fibre as in Fig. 3: two pairs on opposite sides, of two lengths, and one on top."""
    start = np.array(
        [[0.05, 0.0, 0.1], [0.05, 0.12, 0.05], [0.05, -0.12, 0.05], [0.05, 0.12, -0.05], [0.05, -0.12, -0.05]]
    )
    end = start + np.array([[0.9], [0.9], [0.9], [0.5], [0.5]]) * [1.0, 0.0, 0.0]
    return rods_between("swing", start, end, sigma)


def seven_rods(sigma: float = np.nan) -> Rods:
    rods = paper_rods()
    start = np.vstack([rods.start, [[0.05, 0.12, 0.05], [0.05, 0.0, -0.1]]])
    return rods_between("swing", start, np.vstack([rods.end, [[0.95, -0.12, 0.05], [0.6, 0.0, -0.1]]]), sigma)


def compliance(shape: BeamProperties) -> Floats:
    return beam_compliance(shape, (3.1e6, 4.7e6), 2.2e6, 9e8)


WRENCHES = np.array(
    [[300.0, -800.0, 500.0, 90.0, -400.0, 650.0], [0, 1000, 0, 0, 0, 0], [0, 0, 1000, 0, 0, 0], [1000, 0, 0, 0, 0, 0],
     [0, 0, 0, 0, 1000, 0], [0, 0, 0, 0, 0, 1000], [0, 0, 0, 1000, 0, 0]]
)  # fmt: skip


@pytest.mark.parametrize("shape", [SHAPE, DRAWN], ids=["plain", "drawn"])
def test_all_loads_come_back_with_an_oblique_rod(shape: BeamProperties) -> None:
    rods = seven_rods()
    tip = WRENCHES @ compliance(shape)
    found = estimate_link(rods, shape, tip @ rod_matrix(rods, shape).T)
    assert found.carried == UNKNOWNS
    assert found.redundancy == 1
    np.testing.assert_allclose(found.displacement, tip, rtol=0.0, atol=1e-9 * np.linalg.norm(tip, axis=1).min())
    for row, truth in zip(found.displacement, tip, strict=True):
        assert np.linalg.norm(row - truth) < 1e-9 * np.linalg.norm(truth)


def test_five_rods_along_the_fibre_carry_all_but_torsion() -> None:
    rods, shape = paper_rods(), SHAPE
    tip = WRENCHES[:6] @ compliance(shape)
    found = estimate_link(rods, shape, tip @ rod_matrix(rods, shape).T)
    assert set(UNKNOWNS) - set(found.carried) == {"torsion"}
    assert found.known.tolist() == [True, True, True, False, True, True]
    np.testing.assert_allclose(found.displacement[:, found.known], tip[:, found.known], rtol=0, atol=1e-13)
    assert np.isnan(found.displacement[:, 3]).all()
    assert not found.torsion.identifiable
    assert "oblique" in found.torsion.why


def test_the_bound_on_the_twist_holds() -> None:
    """Rods as straight lines between two points of a twisted link: a twist at the bound lengthens one as it says."""
    rods, tip = paper_rods(1e-6), np.array([[0.0, 1e-4, -5e-5, 0.0, 7e-5, 1.4e-4]])
    read = tip @ rod_matrix(rods, SHAPE).T
    bound = estimate_link(rods, SHAPE, read).torsion.bound
    assert bound is not None

    def grown(twist: float) -> Floats:
        ends = []
        for points in (rods.start, rods.end):
            angle = twist * points[:, 0] / LENGTH
            y = points[:, 1] * np.cos(angle) - points[:, 2] * np.sin(angle)
            z = points[:, 1] * np.sin(angle) + points[:, 2] * np.cos(angle)
            ends.append(np.column_stack([points[:, 0], y, z]))
        return np.asarray(np.linalg.norm(ends[1] - ends[0], axis=1) - rods.length)

    allowed = np.abs(read[0]) + 2e-6
    assert np.max(grown(bound) / allowed) == pytest.approx(1.0, rel=1e-3)
    assert bound < 0.1


@pytest.mark.parametrize("flat", [1.0, 1.5, 3.0])
@pytest.mark.parametrize("wall", [0.004, 0.012, None])
def test_the_load_bounds_the_twist_of_closed_sections(flat: float, wall: float | None) -> None:
    width, height = 0.1 * flat, 0.1
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * [width / 2.0, height / 2.0]
    holes = [] if wall is None else [inner_outline(corners, wall)]
    section = solve_section(corners, holes, young=2.1e11, shear=2.1e11 / 2.7)
    moment = np.array([-300.0, 200.0])
    unknown = Torsion(False, 1.0, "no rod sees it")
    found = bounded_by_load(unknown, moment, LENGTH / np.array([section.EI2, section.EI3]))
    assert found.bound is not None
    twist = 300.0 * LENGTH / section.GJ
    assert twist < found.bound < 12.0 * twist
    assert "at most" in found.why
    assert bounded_by_load(unknown, moment, np.array([np.nan, 1.0])) is unknown


def test_warping_decay_or_an_oblique_rod_show_the_twist() -> None:
    plain = paper_rods()
    warping = np.array([[3e-3, 3e-3], [2e-3, 2e-3], [-2e-3, -2e-3], [-2e-3, -2e-3], [2e-3, 2e-3]])
    held = Rods(plain.link, plain.names, plain.start, plain.end, warping, plain.sigma)
    four = ("tip force 2", "tip force 3", "tension", "torsion")
    shape = BeamProperties(LENGTH, warping_decay=0.2)
    assert not estimate_link(held, SHAPE, np.zeros((1, 5))).torsion.identifiable
    tip = end_fields(shape)[:, [0, 1, 2, 3]] @ np.array([1e-4, 2e-4, 1e-5, 3e-4])
    found = estimate_link(held, shape, (rod_matrix(held, shape) @ tip)[None], unknowns=four)
    assert found.torsion.identifiable
    np.testing.assert_allclose(found.displacement[0], tip, rtol=1e-9, atol=1e-16)
    assert "torsion" in rod_design(seven_rods(), SHAPE).names


def test_what_is_not_carried_is_stated() -> None:
    """Four rods carry no tip moment: the error under one is the one that is stated."""
    rods = paper_rods().pick([0, 1, 2, 3])
    three = ("tip force 2", "tip force 3", "tension")
    found = estimate_link(rods, SHAPE, np.zeros((1, 4)), unknowns=three)
    stated = {error.load: error for error in found.shape_errors}
    assert set(stated) == {"torsion", "tip moment 2", "tip moment 3", "even load 2", "even load 3"}
    moment = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]) * 500.0
    tip = compliance(SHAPE) @ moment
    back = estimate_link(rods, SHAPE, (rod_matrix(rods, SHAPE) @ tip)[None], unknowns=three).untwisted[0]
    error = stated["tip moment 2"]
    np.testing.assert_allclose((back - tip) / tip[5], error.error / error.truth[5], atol=1e-12)
    assert np.linalg.norm(back[:3] - tip[:3]) / np.linalg.norm(tip[:3]) == pytest.approx(error.relative)
    assert 0.05 < error.relative < 0.5
    assert stated["torsion"].relative == pytest.approx(1.0)


def test_even_load_is_a_quartic() -> None:
    """q over the whole link: u(L) = q L⁴/8EI, φ(L) = q L³/6EI (Gross, Hauger, table 4.3)."""
    curvature = 1.0 * LENGTH**2 / 2.0  # q L²/2 over EI = 1
    end = end_fields(SHAPE)[:, 6] * curvature
    np.testing.assert_allclose([end[1], end[5]], [LENGTH**4 / 8.0, LENGTH**3 / 6.0])
    x = np.linspace(0.0, LENGTH, 9)
    field = axis_fields(SHAPE, x)[6, 1] * curvature
    np.testing.assert_allclose(field, (6 * LENGTH**2 * x**2 - 4 * LENGTH * x**3 + x**4) / 24.0, atol=1e-12)
    (error,) = (
        e for e in shape_errors(paper_rods(), SHAPE, rod_design(paper_rods(), SHAPE)) if e.load == "even load 2"
    )
    assert error.relative < 0.05


@pytest.mark.parametrize("source", ["stated", "residuals"])
def test_intervals_hold_over_200_simulations(source: str) -> None:
    """1 µm rods: 95 % intervals of all known components, pooled, cover 93–97 % of the truths."""
    rods = seven_rods(1e-6 if source == "stated" else np.nan)
    loads = WRENCHES
    tip = loads @ compliance(SHAPE)
    read, rng = tip @ rod_matrix(rods, SHAPE).T, np.random.default_rng(4)
    inside, pulls = [], []
    for _ in range(200):
        found = estimate_link(rods, SHAPE, read + 1e-6 * rng.standard_normal(read.shape))
        assert found.sigma_source == source
        # one state each: the components of one state share their rods
        inside.append(np.abs(found.displacement - tip) <= found.interval())
        pulls.append((found.displacement - tip) / np.sqrt(np.diag(found.covariance)))
    assert 0.93 <= np.mean(inside) <= 0.97
    assert np.all(np.mean(inside, axis=(0, 1)) > 0.90)
    # Student's t has a wider spread than one, with the seven degrees of freedom that seven states leave: 7/5
    assert np.mean(np.square(pulls)) == pytest.approx(1.0 if source == "stated" else 7.0 / 5.0, rel=0.1)


def test_a_noisy_rod_counts_less() -> None:
    """One rod of 20 µm among those of 1 µm: the end is known nearly as well as without it, and as well as is said."""
    rods, six = seven_rods(1e-6), seven_rods(1e-6).pick([0, 1, 2, 3, 4, 5])
    sigma, rng = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 20.0]) * 1e-6, np.random.default_rng(2)
    tip = np.tile(WRENCHES[:1] @ compliance(SHAPE), (2000, 1))
    read = tip @ rod_matrix(rods, SHAPE).T
    found = estimate_link(rods, SHAPE, read + sigma * rng.standard_normal(read.shape), sigma=sigma)
    scatter = np.std(found.displacement, axis=0)
    np.testing.assert_allclose(scatter, np.sqrt(np.diag(found.covariance)), rtol=0.06)
    without = np.sqrt(np.diag(estimate_link(six, SHAPE, read[:1, :6]).covariance))
    assert np.all(scatter < 1.06 * without)


def test_a_fifth_rod_that_disagrees_shows() -> None:
    rods = paper_rods(1e-6)
    tip = WRENCHES[:3] @ compliance(SHAPE) * np.array([1, 1, 1, 0, 1, 1])
    three = ("tip force 2", "tip force 3", "tension")
    clean = estimate_link(rods, SHAPE, (tip * 0) @ rod_matrix(rods, SHAPE).T, unknowns=three)
    assert clean.redundancy == 2
    read = np.zeros((30, 5))
    read[:, 3] = 20e-6
    found = estimate_link(rods, SHAPE, read, unknowns=three)
    assert np.argmax(found.disagreement) == 3
    # the others know rod 4 to less than twice its own uncertainty
    assert found.disagreement[3] > 5.0


def test_no_uncertainty_no_interval() -> None:
    found = estimate_link(paper_rods(), SHAPE, np.zeros((3, 5)))
    assert found.sigma_source == "none"
    assert np.isnan(found.interval()).all()
    assert np.isnan(found.disagreement).all()


def test_rod_fields_carry_their_sign() -> None:
    """Bending towards +x3 shortens a rod on the +x3 side (φ2 = −u3′, u1 = x3 φ2)."""
    rods = rods_between("swing", np.array([[0.1, 0.0, 0.1]]), np.array([[0.9, 0.0, 0.1]]))
    assert rod_fields(rods, SHAPE)[0, UNKNOWNS.index("tip force 3")] < 0.0


def test_rods_that_scatter_as_stated_disagree_by_one() -> None:
    """Leave-one-rod-out residuals over their uncertainty: their rms over n states is 1 ± 1/√(2n)."""
    n = 5000
    read = 1e-6 * np.random.default_rng(3).standard_normal((n, 7))
    found = estimate_link(seven_rods(1e-6), SHAPE, read)
    # only the oblique rod, the sixth, reads the twist: nothing contradicts it
    assert np.flatnonzero(np.isnan(found.disagreement)).tolist() == [5]
    np.testing.assert_allclose(np.delete(found.disagreement, 5), 1.0, atol=5.0 / np.sqrt(2.0 * n))
