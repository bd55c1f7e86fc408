"""Pages on several tracked bodies and on dual quaternions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from stiffcal.identification.bodies.body_results import Component, JointLineResult
from stiffcal.identification.bodies.joint_lines import COMPONENTS
from stiffcal.report.blocks import Paragraph, PictureBlock, ReportSection, TableBlock
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.joint_motion import draw_about_axes, draw_joint
from stiffcal.report.joint_curves import JointCurve, JointPicture
from stiffcal.report.sections import dual_quaternions, joint_motion, not_identified
from tests.laboratory.fits import with_fit
from tests.laboratory.report_content import made_up_content


def curve(component: Component, curved: bool = False) -> JointCurve:
    rng = np.random.default_rng(COMPONENTS.index(component))
    turns = component[0] == "r"
    load = rng.uniform(-1000.0, 1000.0, 80)
    compliance = 1e-6 if turns else 1e-9
    bend = (compliance, 0.0, -4e-13 if curved else 0.0)
    moved = bend[0] * load + bend[2] * load**3 + rng.normal(0.0, 1e-4, 80)
    std = 2e-8
    line = JointLineResult(
        component=component,
        compliance=compliance,
        std=std,
        above_noise=turns,
        curved=curved and component == "rz",
        curve=list(bend),
        p_curved=0.5,
        scatter=1e-4,
        largest=1e-3,
        n_states=80,
    )
    return JointCurve(line, load, moved, np.repeat([0, 1], 40))


def joint(number: int, curved: bool = False) -> JointPicture:
    curves = tuple(curve(component, curved and component == "rz") for component in COMPONENTS)
    between = ("base" if number == 1 else f"leds{number - 1}", f"leds{number}")
    return JointPicture(f"joint {number} (A{number})", between, ("one", "two"), curves, {"rz": (1.1e-6, 1e-8, True)})


JOINTS = (joint(1), joint(2, curved=True), joint(3))


def content(**identify: Any) -> ReportContent:
    made = made_up_content(n_runs=1)
    return replace(with_fit(made, **identify), joint_pictures=JOINTS)


def section(made: ReportContent) -> ReportSection:
    found = joint_motion.section(made)
    assert isinstance(found, ReportSection)
    return found


def test_nothing_with_one_tracked_body() -> None:
    assert joint_motion.section(made_up_content(n_runs=1)) is None
    assert dual_quaternions.section(made_up_content(n_runs=1)) is None


def test_all_displacements_in_one_table_with_those_above_the_noise() -> None:
    blocks = section(content()).blocks
    assert isinstance(blocks[0], Paragraph)
    assert "9 of 9 rotations and 0 of 9 translations" in blocks[0].text
    (table,) = [block for block in blocks if isinstance(block, TableBlock)]
    assert len(table.rows) == 18
    about_axis = [row for row in table.rows if row[1] == "rotation about the axis"]
    assert [row[5] for row in about_axis] == ["yes", "yes, nonlinear", "yes"]
    shifts = [row for row in table.rows if row[1].startswith("translation")]
    # 1e-9 m/N with 2e-8 of uncertainty: the stiffness is at least 1 / (1e-9 + 1.96 · 2e-8)
    assert {row[2] for row in shifts} == {"above 24.9"}
    assert {row[3] for row in shifts} == {"–"}
    assert [row[3] for row in about_axis] == ["(9.09 ± 0.16)·10⁵"] * 3


def test_pictures_have_units_and_say_what_rises() -> None:
    pictures = [block for block in section(content()).blocks if isinstance(block, PictureBlock)]
    assert len(pictures) == 4
    assert "joint 2 (A2)" in pictures[0].caption
    figure = draw_joint(JOINTS[1])
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["not significant"] * 3 + ["significant"] * 2 + ["significant, nonlinear"]
    assert all("[" in axes.get_xlabel() and "[" in axes.get_ylabel() for axes in figure.axes)
    overview = draw_about_axes(JOINTS)
    assert overview.axes[0].get_title(loc="left") == "joint 1 (A1): significant"


def test_couplings_are_reported_in_words() -> None:
    coupled = (replace(JOINTS[0], couplings=()), replace(JOINTS[1], couplings=(("rz", "tz"),)))
    for joints, words in (
        (JOINTS, "can be identified"),
        (coupled[:1], "No off-diagonal element is significant"),
        (coupled, "joint 2 (A2): rotation about the axis with the force along z"),
    ):
        blocks = section(replace(content(), joint_pictures=joints)).blocks
        assert any(isinstance(block, Paragraph) and words in block.text for block in blocks)


def test_cartesian_stiffness() -> None:
    matrix = np.diag([1e6, 2e6, 3e6, 1e5, 2e5, 3e5]).tolist()
    full = {
        "run": "one", "target": "leds6", "n_states": 90, "equation_15": matrix, "from_compliance": matrix,
        "fullness": {"wrench": 0.1, "displacement": 0.1},
        "over_noise": 0.9,
    }  # fmt: skip
    found = section(content(cartesian_stiffness=[full]))
    table = [block for block in found.blocks if isinstance(block, TableBlock)][-1]
    assert table.rows[0] == ("one", "Schneider et al. 2014, eq. 15", "1.00", "2.00", "3.00", "100", "200", "300")
    made = replace(content(cartesian_stiffness=[full]), joint_pictures=())
    assert section(made).title == "Cartesian stiffness"


def test_dual_quaternions() -> None:
    one = {
        "name": "joint-compliance.j1.c", "matrix": 2e-6, "dual_quaternion": 2e-6, "unweighted_in_metres": 2.5e-6,
        "unweighted_in_millimetres": None,
    }  # fmt: skip
    both = {"largest_relative_difference": 3e-13, "parameters": [one]}
    found = dual_quaternions.section(content(dual_quaternions=both))
    assert found is not None
    text, table = found.blocks
    assert isinstance(text, Paragraph)
    assert "3·10⁻¹³" in text.text
    assert isinstance(table, TableBlock)
    assert list(table.rows[0])[1:] == ["5.00000·10⁵", "5.00000·10⁵", "4.00000·10⁵", "–"]


def test_springs_in_the_noise_are_named_together() -> None:
    lost = [
        {
            "name": f"joint-translation.j{k}.tx",
            "effect": "joint-translation",
            "where": {"joints": [k]},
            "value": 1e-9,
            "std": 2e-9,
            "interval": [0.0, 5e-9],
            "unit": "m/N",
            "fixed": False,
            "poorly_known": True,
            "above_noise": False,
            "identifiable": True,
        }
        for k in (1, 2, 3, 4)
    ]
    found = not_identified.section(content(parameters=lost, not_identifiable=[]))
    assert isinstance(found, ReportSection)
    assert [len(getattr(block, "texts", ())) for block in found.blocks] == [0, 1]
