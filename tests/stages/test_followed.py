"""The picture of `diagnose`: the residual over what the first missing effect follows."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.diagnosis.answers.pattern_results import CompliancePattern, FollowedBy, PatternPoint
from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where
from stiffcal.stages.diagnoses.followed import followed_residual
from stiffcal.stages.steps import RunContext
from stiffcal.store import Store
from tests.laboratory.few_effects import few_effects
from tests.laboratory.small_campaign import write_small_campaign

BACKLASH = """
[[effects]]
type = "backlash"
joints = [3]
[effects.parameters]
"backlash.j3.width" = { value = 1.0e-3 }
"""


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, DiagnoseResult]:
    """A robot with play in a joint, which its model does not know."""
    folder = write_small_campaign(tmp_path_factory.mktemp("followed") / "play", hidden=BACKLASH)
    with few_effects():
        return folder, diagnose_campaign(folder)


def test_the_evidence_of_the_missing_effect_is_drawn(diagnosed: tuple[Path, DiagnoseResult]) -> None:
    folder, diagnosis = diagnosed
    assert [effect.effect for effect in diagnosis.missing] == ["backlash"]
    found = followed_residual(folder, diagnosis, RunContext())
    assert found is not None
    assert (found.follows, found.follows_unit, found.unit) == (diagnosis.evidence[0].driver, "N·m", "mm")
    table = Store(folder / "store").read_table("evidence")
    assert found.x == pytest.approx(table.column("driver").to_numpy())
    assert found.y == pytest.approx(1e3 * table.column("before").to_numpy(), nan_ok=True)
    # another diagnosis than the stored one, without evidence
    assert followed_residual(folder, replace(diagnosis, evidence=[]), RunContext()) is None
    assert followed_residual(folder, replace(diagnosis, missing=[]), RunContext()) is None


def test_a_compliance_that_nothing_accounts_for_is_drawn_run_by_run(diagnosed: tuple[Path, DiagnoseResult]) -> None:
    folder, diagnosis = diagnosed
    pattern = CompliancePattern(
        joint=2, follows=FollowedBy.JOINT_ANGLE, of_joint=1, share=0.9, p_value=1e-6,
        heldout_rms_before=Rms(1e-4, None), heldout_rms_after=Rms(1e-5, None),
        scale=1.0, parameters=[], alternatives=[], curve=[],
        points=[PatternPoint(run=f"r{k}", at=0.1 * k, compliance=1e-8 * k, std=1e-9) for k in range(4)],
    )  # fmt: skip
    found = followed_residual(folder, replace(diagnosis, missing=[], pattern=pattern), RunContext())
    assert found is not None
    assert found.follows_unit == "°"
    assert found.x == pytest.approx(np.degrees([0.0, 0.1, 0.2, 0.3]))
    assert found.y == pytest.approx([0.0, 0.01, 0.02, 0.03])
    few = replace(pattern, points=pattern.points[:2])
    assert followed_residual(folder, replace(diagnosis, missing=[], pattern=few), RunContext()) is None


@pytest.mark.parametrize(("effect", "unit"), [("stribeck", "rad/s"), ("friction-temperature", "K")])
def test_of_a_moving_joint_the_torque_is_drawn(
    diagnosed: tuple[Path, DiagnoseResult], tmp_path: Path, effect: str, unit: str
) -> None:
    bench = Path(__file__).parents[2] / "campaigns" / "joints" / "07"
    folder = Path(shutil.copytree(bench, tmp_path / "bench", ignore=shutil.ignore_patterns("store")))
    missing = [ProposedEffect(effect=effect, where=Where(joints=[1]), alternatives=[])]
    found = followed_residual(folder, replace(diagnosed[1], missing=missing, evidence=[]), RunContext())
    assert found is not None
    assert (found.unit, found.follows_unit) == ("N·m", unit)
    assert np.nanmax(np.abs(found.y)) > 1.0
    # what turns about no axis of a joint's own has no driver in these rows
    missing = [ProposedEffect(effect="seat-shift", where=Where(), alternatives=[])]
    assert followed_residual(folder, replace(diagnosed[1], missing=missing, evidence=[]), RunContext()) is None
