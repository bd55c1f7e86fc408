"""Thresholds from manifest and file, and the baseline they name: where it may lie, what it may be."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from stiffcal.campaign.manifest.thresholds import load_thresholds
from stiffcal.commands.export import export_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.revision import REVISION
from stiffcal.stages.steps import RunContext, open_store
from tests.laboratory.small_campaign import write_small_campaign


def ask(campaign: Path, thresholds: str) -> None:
    manifest = campaign / "campaign.toml"
    manifest.write_text(manifest.read_text(encoding="utf-8") + f"\n[thresholds]\n{thresholds}\n", encoding="utf-8")


@pytest.fixture(scope="module")
def softer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same robot once more, and its model as a file in which joint 2 was 30 % stiffer."""
    return write_small_campaign(tmp_path_factory.mktemp("softer") / "softer", seed=5, poses=3)


def baseline_of(campaign: Path, factor: float) -> Path:
    """Write the campaign's model into its folder, joint 2 that much as stiff as it is now."""
    file = campaign / "baseline.json"
    file.unlink(missing_ok=True)  # it was changed by hand: `export` would not write over it
    export_campaign(campaign, output=file)
    document = json.loads(file.read_text(encoding="utf-8"))
    for one in document["parameters"]:
        if one["where"] == {"joints": [2]}:
            one["value"], one["std"] = one["value"] / factor, one["std"] / factor
            one["stiffness"] *= factor
    file.write_text(json.dumps(document), encoding="utf-8")
    return file


def test_drift_against_a_stored_model(campaign: Path) -> None:
    baseline_of(campaign, 1.3)
    ask(campaign, 'baseline = "baseline.json"\nmax_drift = 0.1')
    document = validate_campaign(campaign)
    assert document.passed is False
    (line,) = document.failed
    assert line.startswith("stiffness of A2 is −23.1 % against baseline.json")
    # the verdict is renewed when the baseline is, without fitting or validating anew
    baseline_of(campaign, 1.0)
    said: list[str] = []
    assert validate_campaign(campaign, RunContext(notify=said.append)).passed is True
    assert said == []
    assert open_store(campaign, RunContext()).read_document("validate")["passed"] is True


def test_drift_against_a_model_of_another_revision_is_not_judged(campaign: Path) -> None:
    file = baseline_of(campaign, 1.3)
    file.write_text(
        json.dumps(json.loads(file.read_text(encoding="utf-8")) | {"revision": REVISION - 1}), encoding="utf-8"
    )
    ask(campaign, 'baseline = "baseline.json"\nmax_drift = 0.1')
    document = validate_campaign(campaign)
    assert document.failed == []
    (check,) = (one for one in document.checks if one.where == "A2")
    assert check.held is None


def test_a_campaign_as_baseline_is_fitted_first(campaign: Path, softer: Path) -> None:
    shutil.copytree(softer, campaign / "before")
    ask(campaign, 'baseline = "before"\nmax_drift = { all = 0.2, A6 = 0.3 }')
    said: list[str] = []
    document = validate_campaign(campaign, RunContext(notify=said.append))
    assert [line.split(":")[0] for line in said] == ["running ingest", "running identify"]
    assert document.passed is True
    assert {check.where for check in document.checks} == {"A1", "A2", "A3", "A4", "A5", "A6"}


def test_a_baseline_outside_is_only_taken_where_the_user_names_it(campaign: Path, tmp_path: Path) -> None:
    outside = shutil.move(baseline_of(campaign, 1.3), tmp_path / "outside.json")
    ask(campaign, 'baseline = "../outside.json"')
    with pytest.raises(InputError, match=r"thresholds\.baseline: .* lies outside the campaign folder; name it"):
        validate_campaign(campaign)
    assert validate_campaign(campaign, RunContext(reach=(tmp_path,))).passed is False
    file = tmp_path / "thresholds.toml"
    file.write_text('schema = "stiffcal/thresholds/1"\n[validate]\nbaseline = "outside.json"\n')
    thresholds = load_thresholds(file)
    assert thresholds.baselines() == (Path(outside).resolve(),)
    document = validate_campaign(campaign, RunContext(reach=thresholds.baselines()), thresholds=thresholds)
    assert document.passed is False


def test_thresholds_of_a_file_go_before_the_manifests_and_are_not_stored(campaign: Path, tmp_path: Path) -> None:
    ask(campaign, "max_rms_m = 1e-3\nmax_relative = 0.5")
    file = tmp_path / "thresholds.toml"
    file.write_text(
        'schema = "stiffcal/thresholds/1"\n[validate]\nmax_rms_m = 1e-9\n[campaigns.small.validate]\nmax_rms_m = 1e-6\n'
    )
    document = validate_campaign(campaign, thresholds=load_thresholds(file))
    assert document.thresholds == {"max_rms_m": 1e-6, "max_relative": 0.5}
    assert document.failed[0].endswith("is above max_rms_m = 0.00100 mm")
    assert open_store(campaign, RunContext()).read_document("validate")["passed"] is True


@pytest.mark.parametrize(
    ("thresholds", "line"),
    [
        ("max_drift = 0.1", r"thresholds\.max_drift: no baseline is stated; state"),
        ('baseline = "nowhere"', r"no such file or folder: nowhere; name a campaign folder, or a model"),
        ('baseline = "robot.toml"', r"robot\.toml: cannot be read as a model"),
        ('baseline = "list.json"', r"list\.json: schema: not a fitted model"),
        ('baseline = "half.json"', r"half\.json: parameters: a parameter is incomplete"),
        ('baseline = "b"\nmax_drift = { A7 = 0.1 }', r"thresholds\.max_drift\.A7: there is no such joint; use A1"),
    ],
)
def test_mistakes_in_thresholds(campaign: Path, thresholds: str, line: str) -> None:
    (campaign / "list.json").write_text("[]")
    (campaign / "half.json").write_text('{"schema": "stiffcal/identify/1", "parameters": [{"name": "x"}]}')
    ask(campaign, thresholds)
    with pytest.raises(InputError, match=line):
        validate_campaign(campaign)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("[validate]\nmax_rms_m = 1e-4\n", r"schema.*missing|schema"),
        ('schema = "stiffcal/thresholds/1"\n[validate]\nmax_rms = 1e-4\n', r"max_rms.*max_rms_m"),
        ('schema = "stiffcal/thresholds/1"\n[campaigns.a.validate]\nmax_drift = "much"\n', r"campaigns\.a\.validate"),
    ],
)
def test_mistakes_in_a_file_of_thresholds(tmp_path: Path, text: str, line: str) -> None:
    file = tmp_path / "thresholds.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=line):
        load_thresholds(file)


def test_a_joint_that_only_the_file_names(campaign: Path, tmp_path: Path) -> None:
    file = tmp_path / "thresholds.toml"
    file.write_text('schema = "stiffcal/thresholds/1"\n[validate]\nmin_stiffness = { J1 = 1e5 }\n')
    with pytest.raises(InputError, match=r"min_stiffness\.J1: small has no such joint; use A1, A2"):
        validate_campaign(campaign, thresholds=load_thresholds(file))
