"""What `compare` shows carries the name of what it is; two different robots are not compared."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiffcal.campaign.loading import load_campaign
from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.pages import draw_page
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.answers.before_after import EstimatedParameter, values_before_and_after
from stiffcal.mechanics.axis_distances import first_difference
from stiffcal.mechanics.chain import Chain
from stiffcal.model.summary import Where
from stiffcal.show.pages import page_of
from stiffcal.validation.compare_result import CompareResult
from stiffcal.validation.one_robot import amplitude_of, require_one_robot
from tests.laboratory.fits import parameter

CAMPAIGNS = Path(__file__).resolve().parents[2] / "campaigns"


def test_a_stiffness_is_not_called_a_compliance() -> None:
    stiffness = EstimatedParameter(
        name="joint-compliance.j2.c", effect="joint-compliance", where=Where(joints=[2]), unit="N·m/rad", value=1e6,
        interval=[0.98e6, 1.02e6],
    )  # fmt: skip
    width = EstimatedParameter(
        name="backlash.j2.b", effect="backlash", where=Where(joints=[2]), unit="rad", value=1e-4, interval=None
    )
    result = CompareResult(
        warnings=[], before="a", after="b", parameters=[], only_before=[], only_after=[],
        before_after=values_before_and_after([stiffness, width], [stiffness, width]), p_value_all=None, changed=[],
        origin="own",
    )  # fmt: skip
    shown = StringIO()
    draw_page(AnswerConsole(file=shown, width=200), page_of(result))
    first, second = (line for line in shown.getvalue().splitlines() if "joint 2" in line or "j2" in line)
    assert first.startswith("joint-compliance, joint 2, stiffness ")
    assert "(1.000 ± 0.020)·10⁶" in first
    assert second.startswith("backlash.j2.b ")


def test_values_of_one_kind_fit_eighty_columns_and_a_remark_of_several_is_explained_once() -> None:
    estimates = [
        EstimatedParameter(
            name=f"joint-compliance.j{joint}.c", effect="joint-compliance", where=Where(joints=[joint]), unit="N·m/rad",
            value=1e6, interval=[0.98e6, 1.02e6], is_shifted=True,
        )
        for joint in range(1, 7)
    ]  # fmt: skip
    result = CompareResult(
        warnings=[], before="a", after="b", parameters=[], only_before=[], only_after=[],
        before_after=values_before_and_after(estimates, estimates), p_value_all=None, changed=[], origin="own",
    )  # fmt: skip
    shown = StringIO()
    draw_page(AnswerConsole(file=shown, width=80, force_terminal=True, color_system=None), page_of(result))
    lines = shown.getvalue().splitlines()
    assert len([line for line in lines if line.startswith("joint ")]) == 6
    assert all(line.split()[-1] == "shifted" for line in lines if line.startswith("joint "))
    assert max(map(len, lines)) <= 80
    assert len(lines) <= 12


def test_a_curve_that_takes_the_place_of_a_straight_law_is_compared() -> None:
    assert amplitude_of(parameter("cubic-stiffness.j2.p1", 2e4)) == pytest.approx(2e4)
    assert amplitude_of(parameter("joint-compliance.j2.c", 2e-6)) == pytest.approx(2e-6)


def chain_of(campaign: str) -> Chain:
    """Return the chain of a bundled campaign."""
    return load_campaign(CAMPAIGNS / campaign, check_files=False).chain


def test_another_robot_is_recognised_by_how_its_axes_lie() -> None:
    chain = chain_of("irb4400")
    assert first_difference(chain, chain) is None
    assert first_difference(chain, chain_of("kr125")) is not None


def test_a_calibrated_geometry_is_the_same_robot() -> None:
    chain, random = chain_of("irb4400"), np.random.default_rng(3)
    fixed = chain.fixed.copy()
    fixed[:, :3, 3] += random.normal(0.0, 1e-3, (chain.n_joints, 3))
    turn = Rotation.from_rotvec(random.normal(0.0, 2e-3, (chain.n_joints, 3))).as_matrix()
    fixed[:, :3, :3] = fixed[:, :3, :3] @ turn
    assert first_difference(chain, replace(chain, fixed=fixed)) is None


def test_two_different_robots_are_refused() -> None:
    with pytest.raises(InputError) as fault:
        require_one_robot([chain_of("irb4400"), chain_of("kr125")], Path("a"), Path("b"))
    assert fault.value.code is FaultCode.ROBOT_MISMATCH
