"""The link's displacement field against closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.effects.link_beam import LinkBeam
from stiffcal.measurements.rods import BeamProperties, rods_between
from stiffcal.mechanics.beam import (
    TORSION,
    amplitudes_from_end_displacement,
    axis_displacement,
    beam_compliance,
    end_fields,
    fibre_fields,
)
from stiffcal.mechanics.rods import rod_matrix
from stiffcal.model.effect import NodeLoads, Place

EXACT = 1e-12
OFF_AXIS = BeamProperties(1.2, neutral=(0.012, -0.02), twist_centre=(0.031, 0.015), warping_decay=0.1, warping_hold=0.9)


def test_compliance_is_that_of_the_link_beam() -> None:
    chain = load_campaign(Path(__file__).parents[2] / "campaigns" / "irb4400", check_files=False).chain
    beam, wrench = chain.beams["swing"], np.zeros((2 * chain.n_joints + 2, 6, 6))
    node = 2 * beam.joint
    wrench[node] = np.eye(6)
    rigid = {"EI2": 3.1e6, "EI3": 4.7e6, "GJ": 2.2e6, "EA": 9e8}
    given = np.zeros((6, 6))
    for term in LinkBeam().terms(Place("links", (), "swing"), chain, NodeLoads(wrench, np.zeros((6, 6))), {}):
        given[term.component] += term.value / rigid[term.symbol]
    shape = BeamProperties(beam.length)
    np.testing.assert_allclose(beam_compliance(shape, (3.1e6, 4.7e6), 2.2e6, 9e8), given, rtol=EXACT, atol=1e-22)


def test_compliance_of_an_unsymmetric_section_is_symmetric() -> None:
    compliance = beam_compliance(OFF_AXIS, (3.1e6, 4.7e6), 2.2e6, 9e8, product=1.1e6)
    np.testing.assert_allclose(compliance, compliance.T, rtol=EXACT, atol=1e-13 * np.abs(compliance).max())
    assert np.linalg.eigvalsh(compliance).min() > 0.0


def test_force_next_to_the_twist_centre_twists_and_one_next_to_the_fibre_bends() -> None:
    compliance = beam_compliance(OFF_AXIS, (3.1e6, 4.7e6), 2.2e6, 9e8)
    # A force and the moment that moves it to the twist centre do not twist.
    n2, n3 = OFF_AXIS.neutral
    c2, c3 = OFF_AXIS.twist_centre
    assert abs(compliance[3] @ [0.0, 1.0, 0.0, -c3, 0.0, 0.0]) < 1e-20
    assert abs(compliance[3] @ [0.0, 0.0, 1.0, c2, 0.0, 0.0]) < 1e-20
    assert np.abs(compliance[4:] @ [1.0, 0.0, 0.0, 0.0, n3, -n2]).max() < 1e-20


def test_the_fields_are_cubics_with_a_clamped_end() -> None:
    x = np.linspace(0.0, 1.2, 9)
    for tip in np.eye(6):
        moved = axis_displacement(BeamProperties(1.2), tip[None], x)[0]
        assert not moved[0].any()
        np.testing.assert_allclose(moved[-1], tip, atol=EXACT)
        for i in range(4):
            fitted = np.polynomial.Polynomial.fit(x, moved[:, i], 3)(x)
            np.testing.assert_allclose(moved[:, i], fitted, atol=1e-13)
        # eq. 2 and 3: slopes by the polynomials' own derivative
        u2, u3 = (np.polynomial.Polynomial.fit(x, moved[:, i], 3).deriv()(x) for i in (1, 2))
        np.testing.assert_allclose(moved[:, 5], u2, atol=1e-12)
        np.testing.assert_allclose(moved[:, 4], -u3, atol=1e-12)


def test_end_and_amplitudes_are_one_to_one() -> None:
    np.testing.assert_allclose(
        end_fields(OFF_AXIS)[:, :6] @ amplitudes_from_end_displacement(OFF_AXIS), np.eye(6), atol=1e-12
    )


def test_opposite_rods_mirror_each_other_and_shorter_ones_read_less() -> None:
    x0, x1, x2 = 0.05, 0.9, 0.6
    start = np.array([[x0, 0.0, 0.1], [x0, 0.0, -0.1], [x0, 0.0, 0.1]])
    end = np.array([[x1, 0.0, 0.1], [x1, 0.0, -0.1], [x2, 0.0, 0.1]])
    read = rod_matrix(rods_between("swing", start, end), BeamProperties(1.0)) @ [0.0, 0.0, 1e-4, 0.0, -1.5e-4, 0.0]
    assert read[0] == -read[1]
    assert abs(read[2]) < abs(read[0])


def test_rods_along_the_fibre_are_blind_to_even_torsion_and_oblique_ones_are_not() -> None:
    start, end = np.array([[0.05, 0.1, 0.08]] * 2), np.array([[0.9, 0.1, 0.08], [0.9, -0.1, 0.08]])
    rods = rods_between("swing", start, end)
    along, across = rod_matrix(rods, BeamProperties(1.0))[:, 3]
    assert along == 0.0
    # by hand: the ends turn by κ x1, and the shift is along the rod by its share
    turned = np.array([0.05, 0.9])
    shift = np.array([[-0.08 * a, x2 * a] for a, x2 in zip(turned, (0.1, -0.1), strict=True)])
    by_hand = (shift[1, 0] - shift[0, 0]) * -0.2 / rods.length[1]
    np.testing.assert_allclose(across, by_hand, rtol=EXACT)


def test_the_link_goes_on_rigidly_beyond_its_ends() -> None:
    moved = axis_displacement(BeamProperties(1.0), np.eye(6), np.array([-0.1, 1.0, 1.2]))
    assert not moved[:, 0].any()
    lever = np.array([0.2, 0.0, 0.0])
    for tip, beyond in zip(moved[:, 1], moved[:, 2], strict=True):
        np.testing.assert_allclose(beyond[1:3], (tip[:3] + np.cross(tip[3:], lever))[1:3], atol=EXACT)
        np.testing.assert_allclose(beyond[4:], tip[4:], atol=EXACT)


def test_a_twist_with_warping_held_back_follows_its_equation() -> None:
    """φ′ = 1 − hold (1 − χ), χ = 1 − cosh((L − x)/d)/cosh(L/d) (Benscoter 1954), integrated by Gauss and Legendre."""
    points, weights = np.polynomial.legendre.leggauss(40)
    decay, hold = 0.1, 0.9
    for end in (0.05, 0.4, 1.2):
        x = 0.5 * end * (points + 1.0)
        free = 1.0 - np.cosh((1.2 - x) / decay) / np.cosh(1.2 / decay)
        twist = 0.5 * end * weights @ (1.0 - hold * (1.0 - free))
        np.testing.assert_allclose(fibre_fields(OFF_AXIS, np.array([end]))[TORSION, 3, 0], twist, rtol=1e-10)
