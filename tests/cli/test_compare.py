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
from stiffcal.validation.one_robot import require_one_robot

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
    first, second = (line for line in shown.getvalue().splitlines() if "joint 2" in line)
    assert "stiffness" in first.split()
    assert "c" not in first.split()
    assert "(1.000 ± 0.020)·10⁶" in first
    assert "b" in second.split()


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
