"""Drawn sections against closed forms and series; Pilkey, Analysis and Design of Elastic Beams (2002), Timoshenko."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.link_sections import with_sections
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.errors import InputError
from stiffcal.extras import install_command
from stiffcal.mechanics.section_mesh import SectionError, inner_outline, section_mesh
from stiffcal.mechanics.section_solver import solve_section

ROOT = Path(__file__).parent


def rectangle(width: float, height: float, centre: tuple[float, float] = (0.0, 0.0)) -> Floats:
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * [width / 2.0, height / 2.0]
    return np.asarray(corners + centre)


def circle(radius: float, corners: int = 96) -> Floats:
    angle = 2.0 * np.pi * np.arange(corners) / corners
    return np.asarray(radius * np.column_stack([np.cos(angle), np.sin(angle)]))


def test_full_rectangle() -> None:
    a, b = 0.2, 0.1
    section = solve_section(rectangle(a, b, (0.03, -0.01)), young=2.1e11, shear=8.1e10)
    odd = np.arange(1, 100, 2)
    series = a * b**3 * (1 / 3 - 64 / np.pi**5 * b / a * np.sum(np.tanh(odd * np.pi * a / 2 / b) / odd**5))
    assert pytest.approx(8.1e10 * series, rel=1e-4) == section.GJ
    assert pytest.approx(2.1e11 * a * b**3 / 12, rel=1e-9) == section.EI2
    assert pytest.approx(2.1e11 * b * a**3 / 12, rel=1e-9) == section.EI3
    assert pytest.approx(2.1e11 * a * b, rel=1e-9) == section.EA
    np.testing.assert_allclose([*section.neutral, *section.twist_centre], [0.03, -0.01] * 2, atol=1e-6)
    # Timoshenko's 5/6, for ν = 0
    np.testing.assert_allclose([section.shear_2, section.shear_3], 8.1e10 * a * b * 5 / 6, rtol=1e-4)


def test_shear_share_of_a_full_rectangle() -> None:
    """3 EI/(5/6 GA L²) = 3 (E/G) h²/(10 L²), h the depth along the force."""
    section = solve_section(rectangle(0.2, 0.1), young=2.6, shear=1.0)
    np.testing.assert_allclose(section.shear_share(1.0), [0.3 * 2.6 * 0.2**2, 0.3 * 2.6 * 0.1**2], rtol=1e-4)


def test_warping_of_a_full_rectangle() -> None:
    a, b = 0.2, 0.1
    section = solve_section(rectangle(a, b))
    point = np.array([0.07, 0.03])
    odd = np.arange(1, 60, 2)
    k, sign = odd * np.pi / b, (-1.0) ** ((odd - 1) // 2)
    # Timoshenko and Goodier, art. 109 (their φ differentiated back): Ψ = x2 x3 − 8 b²/π³ Σ …, antisymmetric in both
    series = np.sum(sign / odd**3 * np.sinh(k * point[0]) / np.cosh(k * a / 2) * np.sin(k * point[1]))
    expected = point[0] * point[1] - 8 * b**2 / np.pi**3 * series
    assert abs(section.warping_at(point[None])[0]) == pytest.approx(abs(expected), rel=3e-3)


def test_tube_does_not_warp() -> None:
    outer, inner = 0.1, 0.09
    section = solve_section(circle(outer), [circle(inner)], 2.1e11, 8.1e10)
    # a polygon of 96 sides has 1 − 2π²/3/96² of the circle's polar moment, and warps no more than its corners make it
    assert pytest.approx(8.1e10 * np.pi / 2 * (outer**4 - inner**4), rel=2e-3) == section.GJ
    assert np.abs(section.warping).max() < 1e-3 * outer**2
    assert pytest.approx(2.1e11 * np.pi / 4 * (outer**4 - inner**4), rel=2e-3) == section.EI2


def test_thin_walled_box() -> None:
    a, b, wall = 0.24, 0.18, 0.004
    section = solve_section(rectangle(a, b), [inner_outline(rectangle(a, b), wall)])
    across, up = a - wall, b - wall
    # Bredt's second formula, and the walls' own torsion with it
    bredt = 2.0 * wall * (across * up) ** 2 / (across + up) + 2.0 * (across + up) * wall**3 / 3.0
    assert pytest.approx(bredt, rel=1e-2) == section.GJ
    # Ψ at the corners of a box of even wall: (a b/4) (a − b)/(a + b) (von Kármán and Christensen 1944)
    corner = across * up / 4.0 * (across - up) / (across + up)
    found = np.abs(section.warping_at(rectangle(across, up)))
    np.testing.assert_allclose(found, corner, rtol=0.02)


def test_channel_has_its_shear_centre_outside() -> None:
    height, width, wall = 0.2, 0.1, 0.004
    h, b = height, width
    outline = np.array(
        [[0, -h / 2], [b, -h / 2], [b, -h / 2 + wall], [wall, -h / 2 + wall], [wall, h / 2 - wall], [b, h / 2 - wall],
         [b, h / 2], [0, h / 2]]
    )  # fmt: skip
    section = solve_section(outline, young=2.1e11, shear=8.1e10)
    hm, bm = height - wall, width - wall / 2
    assert section.twist_centre[0] == pytest.approx(wall / 2 - 3 * bm**2 / (6 * bm + hm), rel=5e-3)
    assert section.twist_centre[1] == pytest.approx(0.0, abs=1e-6)
    gamma = wall * bm**3 * hm**2 / 12 * (3 * bm + 2 * hm) / (6 * bm + hm)
    assert section.warping_rigidity == pytest.approx(2.1e11 * gamma, rel=5e-3)
    assert pytest.approx(8.1e10 * (2 * bm + hm) * wall**3 / 3, rel=5e-3) == section.GJ
    # open: Vlasov's decay
    assert section.warping_hold == pytest.approx(1.0, abs=1e-3)
    assert section.warping_decay == pytest.approx(np.sqrt(2.1e11 * gamma / section.GJ), rel=5e-3)


def test_warping_has_no_mean_and_no_tilt_on_an_angle() -> None:
    angle = np.array([[0.0, 0.0], [0.12, 0.0], [0.12, 0.01], [0.01, 0.01], [0.01, 0.08], [0.0, 0.08]])
    section = solve_section(angle)
    assert section.EI23 != 0.0
    # two legs that meet: the shear centre lies where their middle lines cross
    np.testing.assert_allclose(section.twist_centre, [0.005, 0.005], atol=1.5e-3)


@pytest.mark.parametrize(
    ("loops", "says"),
    [
        ([rectangle(0.2, 0.1), rectangle(0.3, 0.05)], "out of the outline"),
        ([np.array([[0.0, 0.0], [0.1, 0.1], [0.1, 0.0], [0.0, 0.1]])], "encloses nothing|crosses|larger"),
    ],
)
def test_bad_drawings_are_named(loops: list[Floats], says: str) -> None:
    with pytest.raises(SectionError, match=says):
        section_mesh(loops, 0.01)


def test_walls_that_leave_no_hollow() -> None:
    with pytest.raises(SectionError, match="no hollow"):
        inner_outline(rectangle(0.2, 0.1), 0.05)


def robot_with(section: dict[str, object]) -> RobotFile:
    rows = [{"name": "A1", "d_m": 0.5}, {"name": "A2", "alpha_deg": 90.0}, {"name": "A3", "a_m": 0.9}]
    links = {"link2": {"section": section}}
    document = {"schema": "stiffcal/robot/1", "convention": "modified-dh", "joints": rows, "links": links}
    return RobotFile.model_validate(document)


def test_robot_file_draws_a_hollow_section() -> None:
    box = rectangle(0.24, 0.18, (0.0, 0.01)).tolist()
    robot = robot_with({"outline": box, "wall_m": 0.008, "E_Pa": 1.7e11, "G_Pa": 6.6e10})
    chain = chain_of(robot, ROOT)
    (name,) = [n for n, beam in chain.beams.items() if beam.joint == 2]
    assert chain.beams[name].shape.warping_decay is None
    shape = with_sections(chain, robot, [name]).beams[name].shape
    assert shape.neutral == pytest.approx((0.0, 0.01), abs=1e-9)
    assert shape.warping_decay == pytest.approx(0.0279, rel=1e-3)


def test_missing_extra_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "skfem", None)
    robot = robot_with({"outline": rectangle(0.11, 0.12).tolist()})
    chain = chain_of(robot, ROOT)
    with pytest.raises(InputError, match=re.escape(install_command("section"))):
        with_sections(chain, robot, ["link2"])


def test_walls_too_thick_are_named_with_their_place() -> None:
    robot = robot_with({"outline": rectangle(0.1, 0.1).tolist(), "wall_m": 0.06})
    with pytest.raises(InputError, match=r"links\.link2\.section"):
        with_sections(chain_of(robot, ROOT), robot, ["link2"])
