"""campaigns/ipa-ur10: measured places of a UR10; reference values by two independent hands, of all rows."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stiffcal.results.validate_result import ValidateResult
from stiffcal.workflow.diagnose import diagnose_campaign
from stiffcal.workflow.steps import RunContext
from stiffcal.workflow.validate import validate_campaign

FOLDER = Path(__file__).resolve().parents[2] / "campaigns" / "ipa-ur10"
# mm, mean distance in regions left out, of all 1495 rows by hands that share no code with stiffcal
REFERENCE = {"frames": 1.38, "offsets": 1.47, "geometry": 0.443, "springs": 0.379}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    copied = tmp_path_factory.mktemp("ipa") / "ur10"
    return Path(shutil.copytree(FOLDER, copied, ignore=shutil.ignore_patterns("store")))


@pytest.fixture(scope="module")
def validated(folder: Path) -> ValidateResult:
    return validate_campaign(folder, RunContext())


@pytest.mark.parametrize("step", sorted(REFERENCE))
def test_ladder_is_that_of_other_hands(step: str, validated: ValidateResult) -> None:
    """A fifth of the rows, in other regions: within 15 %."""
    assert validated.ladder is not None
    (mean,) = [1e3 * (rung.mean_region or 0.0) for rung in validated.ladder if rung.step == step]
    assert mean == pytest.approx(REFERENCE[step], rel=0.15)


def test_the_spring_of_joint_2_is_identified_and_that_of_joint_3_is_not(validated: ValidateResult) -> None:
    assert validated.elasticity is not None
    verdicts = {joint.joint: joint.verdict for joint in validated.elasticity.joints}
    assert verdicts[2] == "identified"
    assert verdicts[3] != "identified"
    assert verdicts[1] == verdicts[6] == "no-torque"


@pytest.mark.long
def test_far_above_the_noise_nothing_is_named(folder: Path, validated: ValidateResult) -> None:
    diagnosis = diagnose_campaign(folder, RunContext())
    assert diagnosis.missing == []
    assert diagnosis.unexplained
    assert diagnosis.adequate is False
