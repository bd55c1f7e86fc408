"""A campaign folder that brings a store and no logs: a stranger's results are shown, marked, and hold no threshold."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from stiffcal.cli.app import main
from stiffcal.commands.compare import compare_campaigns
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.stages.steps import RunContext
from stiffcal.store import Store
from stiffcal.trust import foreign_content
from tests.laboratory.delivered_store import NOT_YOURS, STRICT, batch, forge, hold, without_logs
from tests.laboratory.small_campaign import write_small_campaign


def test_without_the_logs_a_strangers_results_are_shown_and_marked(
    delivered: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    without_logs(delivered)
    said: list[str] = []
    fit = identify_campaign(delivered, RunContext(notify=said.append))
    assert fit.origin == "foreign"
    assert said[0] == "the logs are missing (raw/states.csv): results that were not computed by you are shown"
    assert validate_campaign(delivered).origin == "foreign"
    with pytest.raises(SystemExit) as ended:
        main(["identify", str(delivered)])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith("not computed by you")


@pytest.mark.parametrize("thresholds", [STRICT, "\n[thresholds]\nmax_rms_m = 1.0\n", ""])
def test_without_the_logs_no_threshold_is_held(made: Path, tmp_path: Path, state: Path, thresholds: str) -> None:
    shutil.copytree(made, tmp_path / "small", symlinks=True)
    folder = without_logs(tmp_path / "small")
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text().replace(STRICT, thresholds))
    forge(folder, "validate", hold)
    document = validate_campaign(folder)
    assert document.passed is False
    assert not any(check.held for check in document.checks)
    assert "not computed by you" in document.failed[0]
    assert batch(folder).state == "not held"
    with pytest.raises(SystemExit) as ended:
        main(["validate", str(folder), "--json"])
    assert ended.value.code == 1


def test_a_fit_of_a_strangers_states_stays_a_strangers(delivered: Path, made: Path) -> None:
    without_logs(delivered)
    (delivered / "model.toml").write_text(
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [2, 3]\n'
    )
    assert identify_campaign(delivered).origin == "foreign"
    assert validate_campaign(delivered).passed is False
    assert Store(delivered / "store").origin_of("identify", "states") == "foreign"
    # When the logs come, all is computed from them.
    shutil.copytree(made / "raw", delivered / "raw")
    said: list[str] = []
    assert identify_campaign(delivered, RunContext(notify=said.append)).origin == "own"
    assert said[0] == NOT_YOURS


def test_the_baseline_of_a_stranger_is_computed_again_or_refused(delivered: Path, made: Path, tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "mine", poses=2)
    shutil.copytree(delivered, folder / "before", symlinks=True)
    with (folder / "campaign.toml").open("a", encoding="utf-8") as file:
        file.write('\n[thresholds]\nbaseline = "before"\nmax_drift = 0.5\n')

    def stiffer(document: dict[str, Any]) -> None:
        for parameter in document["parameters"]:
            parameter.update(value=1e-12, stiffness=1e12)

    forge(folder / "before", "identify", stiffer)
    assert validate_campaign(folder).passed is True  # of the same robot, once it is computed again
    shutil.copytree(made, folder / "again", symlinks=True)
    shutil.rmtree(folder / "before")
    (folder / "again").rename(folder / "before")
    without_logs(folder / "before")
    with pytest.raises(InputError, match=r"thresholds\.baseline: before: the results were not computed by you"):
        validate_campaign(folder)


def test_a_model_of_a_stranger_is_judged_only_after_it_is_computed_again(delivered: Path, tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "mine", poses=2)
    with pytest.raises(InputError, match="its store was not written by you; run stiffcal identify"):
        validate_campaign(folder, model=delivered)
    without_logs(delivered)
    document = validate_campaign(folder, model=delivered)
    assert (document.origin, document.passed) == ("foreign", False)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_comparison_with_a_stranger_s_campaign_is_marked_whichever_comes_first(
    delivered: Path, tmp_path: Path, swapped: bool
) -> None:
    mine, strange = write_small_campaign(tmp_path / "mine", poses=2), without_logs(delivered)
    foreign_content.use_own_results()
    before, after = (mine, strange) if swapped else (strange, mine)
    assert compare_campaigns(before, after).origin == "foreign"
    assert foreign_content.fault_of_foreign_content(KeyError("x")) is not None
    foreign_content.use_own_results()
