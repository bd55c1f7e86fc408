"""`trend`: one robot over several campaigns that differ by a joint, by the set-up, or by nothing."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

import stiffcal
from stiffcal.cli.app import main
from stiffcal.commands.trend import trend_campaigns
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.validation.trend_result import TrendResult
from tests.laboratory.small_campaign import CAMPAIGN, STIFFNESS, write_small_campaign

STATED = "\n[trend]\ndate = 2026-0{}-01\nbetween_campaigns = 0.01\n"
HOOK = "xyz_m = [0.02, 0.0, 0.18]"


def write_series(folder: Path, factors: list[float], manifests: list[str], stated: bool = True) -> list[Path]:
    """Write campaigns of a robot whose joint 2 has each of these shares of its stiffness, and whose true set-up is each
    of these manifests, of which campaign.toml knows nothing.
    """
    folders = []
    for number, (factor, manifest) in enumerate(zip(factors, manifests, strict=True)):
        stiffness = (STIFFNESS[0], factor * STIFFNESS[1], *STIFFNESS[2:])
        month = folder / f"month{number + 1}"
        folders.append(write_small_campaign(month, seed=number + 1, stiffness=stiffness, set_up=manifest))
        text = CAMPAIGN + (STATED.format(number + 1) if stated else "")
        (folders[-1] / "campaign.toml").write_text(text, encoding="utf-8")
    return folders


@pytest.fixture(scope="module")
def worn(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return write_series(tmp_path_factory.mktemp("worn"), [1.0, 1.01, 0.99, 0.9, 0.9], [CAMPAIGN] * 5)


def test_a_joint_that_loses_a_tenth_is_worn(
    worn: list[Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    picture = tmp_path / "trend.svg"
    # the dates decide of the order
    words = ["trend", *map(str, reversed(worn)), "--json", "--max-change", "0.05", "-o", str(picture)]
    with pytest.raises(SystemExit) as ended:
        main(words)
    document = json.loads(capsys.readouterr().out)
    assert ended.value.code == 1
    assert [campaign["date"] for campaign in document["campaigns"]] == [f"2026-0{k}-01" for k in range(1, 6)]
    assert document["alarms"] == document["exceeded"] == ["joint-compliance.j2.c"]
    assert document["cause"]["verdict"] == "wear"
    assert document["cause"]["causes"][0]["joints"] == [2]
    assert document["cause"]["since"] == 3
    joint = document["parameters"][1]
    assert joint["change"] == pytest.approx(-0.1, abs=0.03)
    assert joint["change_interval"][0] < -0.1 < joint["change_interval"][1]
    assert picture.read_bytes().startswith(b"<?xml")


def test_the_python_function_answers_the_same(worn: list[Path]) -> None:
    answer = stiffcal.trend(worn)
    assert answer.alarms == ["joint-compliance.j2.c"]
    assert answer.cause is not None
    assert answer.cause.verdict == "wear"
    assert len(answer.values) == 6 * 5
    assert answer.changes.loc["joint-compliance.j2.c", "changed_from"] == str(worn[3])


def test_without_a_stated_variance_fewer_than_five_campaigns_raise_no_alarm(
    worn: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = [Path(shutil.copytree(folder, tmp_path / folder.name)) for folder in worn[1:]]
    for folder in folders:
        (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    with pytest.raises(SystemExit) as ended:
        main(["trend", *map(str, folders)])
    shown = capsys.readouterr()
    assert ended.value.code == 0
    assert "stiffcal compare DIR1 DIR2" in shown.out + shown.err
    assert "alarm in" not in shown.out


def test_what_cannot_be_followed_is_refused(worn: list[Path], tmp_path: Path) -> None:
    other = Path(shutil.copytree(worn[0], tmp_path / "other"))
    robot = (other / "robot.toml").read_text(encoding="utf-8")
    (other / "robot.toml").write_text(robot.replace("a_m = 0.", "a_m = 1."), encoding="utf-8")
    undated = Path(shutil.copytree(worn[0], tmp_path / "undated"))
    (undated / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    for folders, code in (
        ([worn[0], other], FaultCode.ROBOT_MISMATCH),
        ([worn[0], undated], FaultCode.KEY_MISSING),
        ([worn[0]], FaultCode.OPTION_INVALID),
    ):
        with pytest.raises(InputError) as refused:
            trend_campaigns(folders)
        assert refused.value.faults[0].code is code


@pytest.mark.long
def test_a_change_of_the_set_up_is_no_wear(tmp_path: Path) -> None:
    """The hook is mounted 22 mm from where the manifest has it: three joints seem to change."""
    moved = CAMPAIGN.replace(HOOK, "xyz_m = [0.02, 0.01, 0.20]")
    result = following(tmp_path, [CAMPAIGN] * 3 + [moved] * 2)
    assert len(result.alarms) >= 2
    assert result.cause is not None
    assert result.cause.verdict == "set-up"
    assert result.cause.causes[0].effect == "load-point-offset"


@pytest.mark.practice
def test_a_bearing_that_gives_way_is_no_change_of_the_set_up(tmp_path: Path) -> None:
    """By the changes of the springs alone, a compliant base would be it (odds above 20 to 1)."""
    tilt = """
[[effects]]
type = "bearing-tilt"
joints = [2]
parameters = { "bearing-tilt.j2.x" = { value = 4.4e-7 }, "bearing-tilt.j2.y" = { value = 4.4e-7 } }
"""
    folders = write_series(tmp_path, [1.0] * 3, [CAMPAIGN] * 3)
    for number in (4, 5):
        folders.append(write_small_campaign(tmp_path / f"month{number}", seed=number, hidden=tilt))
        stated = STATED.format(number).replace("0.01", "0.02")
        (folders[-1] / "campaign.toml").write_text(CAMPAIGN + stated, encoding="utf-8")
    cause = trend_campaigns(folders).cause
    assert cause is not None
    assert cause.misfit_grew
    assert cause.causes[0].effect == "base-compliance"
    assert cause.verdict == "unexplained"
    assert "bearing-tilt j2" in cause.explains_residuals


def following(folder: Path, manifests: list[str]) -> TrendResult:
    return trend_campaigns(write_series(folder, [1.0] * len(manifests), manifests))


@pytest.mark.practice
def test_an_unchanged_robot_raises_no_alarm(tmp_path: Path) -> None:
    folders = write_series(tmp_path, [1.0] * 6, [CAMPAIGN] * 6, stated=False)
    result = trend_campaigns(folders)
    assert result.passed
    assert {parameter.variance_from for parameter in result.parameters} == {"campaigns"}
    assert result.cause is None
