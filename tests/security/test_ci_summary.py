"""A pull request's author may tighten what a file of thresholds asks, not loosen it, and hides no choice of theirs."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from stiffcal.batch.author_choices import author_choices
from stiffcal.batch.campaigns import BatchOptions, batch_campaigns
from stiffcal.batch.task import run_task
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.manifest.thresholds import Thresholds, ThresholdsFile, load_thresholds, tighter
from stiffcal.cli.app import main
from stiffcal.commands.export import export_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.results.batch_results import BatchTask, CampaignOutcome
from stiffcal.stages.steps import RunContext
from tests.laboratory.small_campaign import write_small_campaign

HEAD = 'schema = "stiffcal/thresholds/1"\n'


def file_of(text: str) -> ThresholdsFile:
    import tomllib

    return ThresholdsFile.model_validate(tomllib.loads(HEAD + text))


def limits(text: str, **manifest: Any) -> dict[str, object]:
    return file_of(text).limits_for("cell", "cell", Thresholds.model_validate(manifest)).written()


class TestTighter:
    @pytest.mark.parametrize("key", ["max_rms_m", "max_rms_rad", "max_relative", "max_over_noise"])
    def test_the_smaller_error_counts_in_either_file(self, key: str) -> None:
        assert limits(f"[validate]\n{key} = 0.2", **{key: 0.9}) == {key: 0.2}
        assert limits(f"[validate]\n{key} = 0.2", **{key: 0.1}) == {key: 0.1}
        assert limits("[validate]", **{key: 0.1}) == {key: 0.1}

    def test_the_larger_stiffness_counts_joint_by_joint(self) -> None:
        both = limits("[validate]\nmin_stiffness = { all = 1e5, A2 = 1e6 }", min_stiffness={"A2": 1.0, "A3": 7e5})
        assert both == {"min_stiffness": {"all": 1e5, "A2": 1e6, "A3": 7e5}}
        assert limits("[validate]\nmin_stiffness = 1e5", min_stiffness={"A6": 1.0}) == {
            "min_stiffness": {"all": 1e5, "A6": 1e5}
        }
        assert limits("[validate]\nmin_stiffness = { A2 = 1e6 }", min_stiffness=2e6) == {
            "min_stiffness": {"A2": 2e6, "all": 2e6}
        }

    def test_the_files_baseline_stays_and_no_drift_is_added_to_it(self) -> None:
        assert limits('[validate]\nbaseline = "b.json"', baseline="mine.json", max_drift=0.9) == {"baseline": "b.json"}
        assert limits('[validate]\nbaseline = "b.json"\nmax_drift = 0.1', baseline="mine.json", max_drift=0.9) == {
            "baseline": "b.json",
            "max_drift": {"all": 0.1},
        }
        found = limits('[validate]\nbaseline = "b.json"\nmax_drift = { A2 = 0.2 }', max_drift={"A2": 0.1, "A3": 0.9})
        assert found == {"baseline": "b.json", "max_drift": {"A2": 0.1}}

    def test_a_baseline_of_the_campaign_keeps_the_files_drift(self) -> None:
        assert limits("[validate]\nmax_drift = 0.1", baseline="mine.json", max_drift={"A2": 0.5, "A3": 0.01}) == {
            "baseline": "mine.json",
            "max_drift": {"all": 0.1, "A2": 0.1, "A3": 0.01},
        }

    def test_a_section_found_by_the_name_in_the_manifest_alone_loosens_nothing(self) -> None:
        file = file_of("[validate]\nmax_rms_m = 1e-4\n[campaigns.soft.validate]\nmax_rms_m = 1.0\nmax_relative = 0.2")
        assert file.limits_for("soft", "soft", Thresholds()).written() == {"max_rms_m": 1.0, "max_relative": 0.2}
        assert file.limits_for("soft", "cell", Thresholds()).written() == {"max_rms_m": 1e-4, "max_relative": 0.2}

    def test_each_threshold_there_is_has_a_rule(self) -> None:
        whole = Thresholds.model_validate(
            {"max_rms_m": 1, "max_rms_rad": 1, "max_relative": 1, "max_over_noise": 1, "min_stiffness": 1,
             "baseline": "b", "max_drift": 1}
        )  # fmt: skip
        assert set(whole.written()) == set(Thresholds.model_fields)
        assert tighter(whole, Thresholds()) == tighter(Thresholds(), whole) == tighter(whole, whole) == whole


@pytest.fixture(scope="module")
def validated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = write_small_campaign(tmp_path_factory.mktemp("clean") / "cell")
    validate_campaign(folder)
    return folder


@pytest.fixture
def cell(validated: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(validated, tmp_path / "cell", symlinks=True))


@pytest.fixture
def _in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(tasks: list[BatchTask], jobs: int, finished: Callable[[CampaignOutcome], None]) -> None:
        for task in tasks:
            finished(run_task(task))

    monkeypatch.setattr("stiffcal.batch.processes.run_on_this_machine", run)


def add(folder: Path, text: str) -> None:
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text(encoding="utf-8") + text, encoding="utf-8")


EXCLUDED = '\n[[exclude]]\nsource = "table"\nrows = [3, "7-9"]\nwhy = "**bad** <b>day</b> | @lab"\n'


def source_of(folder: Path) -> str:
    return next(iter(load_campaign(folder).manifest.sources))


def test_a_loose_threshold_of_the_campaign_does_not_make_validate_hold(cell: Path, tmp_path: Path) -> None:
    add(cell, "\n[thresholds]\nmax_rms_m = 1.0\n")
    (tmp_path / "limits.toml").write_text(f"{HEAD}[validate]\nmax_rms_m = 1e-9\n")
    file = load_thresholds(tmp_path / "limits.toml")
    document = validate_campaign(cell, RunContext(), thresholds=file)
    assert (document.passed, document.thresholds) == (False, {"max_rms_m": 1e-9})


def test_a_tight_threshold_of_the_campaign_counts_too(cell: Path, tmp_path: Path) -> None:
    add(cell, "\n[thresholds]\nmax_rms_m = 1e-9\n")
    (tmp_path / "limits.toml").write_text(f"{HEAD}[validate]\nmax_rms_m = 1.0\n")
    assert validate_campaign(cell, thresholds=load_thresholds(tmp_path / "limits.toml")).passed is False


JOINTS = range(1, 7)
FIXED = "".join(f'"joint-compliance.j{joint}.c" = {{ value = 1e-12, fixed = true }}\n' for joint in JOINTS)
WITHOUT_MEASURE = {
    "no joint gives": '[[effects]]\ntype = "base-compliance"\n',
    "every joint is fixed": f'[[effects]]\ntype = "joint-compliance"\njoints = "all"\n[effects.parameters]\n{FIXED}',
}


@pytest.mark.parametrize("model", WITHOUT_MEASURE.values(), ids=WITHOUT_MEASURE)
def test_a_model_that_leaves_no_stiffness_to_measure_does_not_hold_the_files_threshold(
    cell: Path, tmp_path: Path, model: str
) -> None:
    (cell / "model.toml").write_text(f'schema = "stiffcal/model/1"\n{model}')
    (tmp_path / "limits.toml").write_text(f"{HEAD}[validate]\nmin_stiffness = 1e9\n")
    document = validate_campaign(cell, thresholds=load_thresholds(tmp_path / "limits.toml"))
    assert (document.passed, len(document.failed)) == (False, len(JOINTS))
    add(cell, "\n[thresholds]\nmin_stiffness = 1e9\n")
    assert validate_campaign(cell).passed is True


def test_a_model_that_fixes_a_stiffness_has_not_kept_to_the_files_baseline(cell: Path, tmp_path: Path) -> None:
    export_campaign(cell, output=tmp_path / "before.json")
    before = json.loads((tmp_path / "before.json").read_text())["parameters"]
    fixed = "".join(f'"{row["name"]}" = {{ value = {row["value"]!r}, fixed = true }}\n' for row in before)
    effect = '[[effects]]\ntype = "joint-compliance"\njoints = "all"\n[effects.parameters]\n'
    (cell / "model.toml").write_text(f'schema = "stiffcal/model/1"\n{effect}{fixed}')
    (tmp_path / "limits.toml").write_text(f'{HEAD}[validate]\nbaseline = "before.json"\nmax_drift = 0.1\n')
    file = load_thresholds(tmp_path / "limits.toml")
    document = validate_campaign(cell, RunContext(reach=file.baselines()), thresholds=file)
    assert (document.passed, len(document.failed)) == (False, len(before))


@pytest.mark.parametrize(
    "wrong",
    [
        {"value": float("nan")},
        {"stiffness": float("inf")},
        {"std": "x"},
        {"where": 3},
        {"value": 10**400},
        {"unit": []},
    ],
    ids=str,
)
def test_a_baseline_whose_numbers_are_none_holds_nothing(cell: Path, wrong: dict[str, Any]) -> None:
    export_campaign(cell, output=cell / "b.json")
    document = json.loads((cell / "b.json").read_text())
    document["parameters"][0] |= wrong
    (cell / "b.json").write_text(json.dumps(document))
    add(cell, '\n[thresholds]\nbaseline = "b.json"\nmax_drift = 0.1\n')
    with pytest.raises(InputError, match="a parameter is incomplete"):
        validate_campaign(cell)


def test_a_baseline_of_the_campaign_does_not_take_the_place_of_the_files(cell: Path, tmp_path: Path) -> None:
    export_campaign(cell, output=cell / "mine.json")
    theirs = json.loads((cell / "mine.json").read_text())
    for parameter in theirs["parameters"]:
        parameter["value"], parameter["std"] = parameter["value"] / 2.0, parameter["std"] / 2.0
        parameter["stiffness"] *= 2.0
    (tmp_path / "before.json").write_text(json.dumps(theirs))
    (tmp_path / "limits.toml").write_text(f'{HEAD}[validate]\nbaseline = "before.json"\n')
    add(cell, '\n[thresholds]\nbaseline = "mine.json"\nmax_drift = 0.99\n')
    file = load_thresholds(tmp_path / "limits.toml")
    document = validate_campaign(cell, RunContext(reach=file.baselines()), thresholds=file)
    assert document.passed is False
    assert "against " in document.failed[0]
    assert "before.json" in document.failed[0]


@pytest.mark.usefixtures("_in_this_process")
def test_every_choice_of_the_author_stands_in_every_summary(
    cell: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = source_of(cell)
    add(cell, EXCLUDED.replace('"table"', f'"{source}"') + "\n[thresholds]\nmax_rms_m = 0.5\nmax_relative = 0.8\n")
    (tmp_path / "limits.toml").write_text(f"{HEAD}[validate]\nmax_rms_m = 0.2\n")
    junit, markdown = tmp_path / "junit.xml", tmp_path / "summary.md"
    words = ["--thresholds", str(tmp_path / "limits.toml"), "--no-report", "--junit", str(junit)]
    with pytest.raises(SystemExit):
        main(["batch", str(cell), *words, "--markdown", str(markdown), "--json"])
    (campaign,) = json.loads(capsys.readouterr().out)["campaigns"]
    choices = {choice["place"]: choice for choice in campaign["choices"]}
    assert choices["exclude[1]"]["kind"] == "exclude"
    assert choices["exclude[1]"]["text"] == f"{source}: rows 3, 7-9 (4) left out: **bad** <b>day</b> | @lab"
    loose, own = choices["thresholds.max_rms_m"]["text"], choices["thresholds.max_relative"]["text"]
    assert loose == "max_rms_m = 0.5: was none at the last validation; not used: the file's 0.2 is tighter"
    assert own == "max_relative = 0.8: was none at the last validation; only in campaign.toml"
    suite = ElementTree.parse(junit).getroot()[0]
    assert {entry.get("name") for entry in suite.iter("property")} == {"exclude", "threshold"}
    (case,) = [case for case in suite.iter("testcase") if case.get("name") == "set in campaign.toml"]
    assert "rows 3, 7-9 (4) left out" in (case.findtext("system-out") or "")
    text = markdown.read_text()
    assert "### Chosen by the authors of the campaigns" in text
    assert "rows 3, 7-9 (4) left out" in text
    assert "not used: the file's 0.2 is tighter" in text
    assert "<b>" not in text
    with pytest.raises(SystemExit):
        main(["batch", str(cell), *words])
    shown = capsys.readouterr().out
    assert "chosen: exclude, exclude[1]: " in shown
    assert "chosen: threshold, thresholds.max_rms_m: " in shown


@pytest.mark.usefixtures("_in_this_process")
def test_choices_are_named_even_where_a_later_step_fails(cell: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("in a later step")

    add(cell, EXCLUDED.replace('"table"', f'"{source_of(cell)}"'))
    monkeypatch.setattr("stiffcal.batch.task.current_fit", fail)
    (campaign,) = batch_campaigns([cell], BatchOptions(jobs=1, report=False)).campaigns
    assert campaign.state == "fault"
    assert campaign.error is not None
    Path(campaign.error.mend.rpartition(" ")[2]).unlink()
    assert [choice.kind for choice in campaign.choices] == ["exclude"]


@pytest.mark.usefixtures("_in_this_process")
def test_a_campaign_without_choices_has_nothing_to_say(cell: Path) -> None:
    (campaign,) = batch_campaigns([cell], BatchOptions(jobs=1, report=False)).campaigns
    assert campaign.choices == []


def test_row_filters_holdouts_and_names_are_choices(cell: Path) -> None:
    campaign = load_campaign(cell)
    manifest = campaign.manifest
    source, name, signal = manifest.signals()[0]
    table = manifest.sources[source]
    filtered = table.model_copy(update={name: signal.model_copy(update={"rows": "Fz < 0"})})
    runs = (manifest.runs[0].model_copy(update={"holdout": True}), *manifest.runs[1:]) if manifest.runs else ()
    changed = manifest.model_copy(
        update={"sources": {**manifest.sources, source: filtered}, "runs": runs, "name": "soft"}
    )
    campaign = type(campaign)(campaign.folder, changed, campaign.robot, campaign.model)
    file = file_of("[validate]\nmax_rms_m = 1e-4\n[campaigns.soft.validate]\nmax_rms_m = 1.0")
    found = author_choices(campaign, file, None)
    texts = [choice.text for choice in found]
    assert "only rows with Fz < 0" in texts
    assert any(text.startswith('name = "soft": ') for text in texts)
    if runs:
        assert f"the held-out poses are those of 1 of {len(runs)} runs: {runs[0].id}" in texts
