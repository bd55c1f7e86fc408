"""A step that is missing or stale is run first and said; what is current is not run again."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.stages.steps import RunContext, key_of_table, open_store, up_to_date_states
from tests.laboratory.small_campaign import STIFFNESS, write_small_campaign


def means_with(said: list[str], update: bool = True) -> RunContext:
    return RunContext(notify=said.append, update=update)


def test_missing_steps_run_first_and_are_said_in_one_line_each(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)
    said: list[str] = []
    validate_campaign(folder, means_with(said))
    assert said == ["running ingest: nothing is ingested yet", "running identify: nothing is fitted yet"]


def test_no_update_refuses_and_names_the_step(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)
    with pytest.raises(InputError, match=r"nothing is ingested yet; run stiffcal ingest"):
        identify_campaign(folder, means_with([], update=False))
    assert not (folder / "store").exists()


def test_what_is_current_is_not_run_again(campaign: Path) -> None:
    before = open_store(campaign, RunContext()).generation
    said: list[str] = []
    identify_campaign(campaign, means_with(said))
    validate_campaign(campaign, means_with(said))
    assert said == ["nothing has changed since fit 1"]
    assert open_store(campaign, RunContext()).generation == before


def test_a_changed_source_is_named_and_everything_after_it_runs_again(campaign: Path) -> None:
    table = campaign / "raw" / "states.csv"
    lines = table.read_text().splitlines()
    table.write_text("\n".join(lines[:-2]) + "\n")
    said: list[str] = []
    document = validate_campaign(campaign, means_with(said))
    assert said[0].startswith("running ingest: changed: raw/states.csv")
    assert said[1].startswith("running identify: the model or the load states have changed")
    assert document.fit_id == "2"


def test_a_changed_model_makes_the_fit_stale_but_not_the_states(campaign: Path) -> None:
    model = campaign / "model.toml"
    model.write_text(model.read_text().replace("[1, 2, 3, 4, 5, 6]", "[1, 2, 3, 4, 5]"))
    said: list[str] = []
    document = validate_campaign(campaign, means_with(said))
    assert [line.split(":")[0] for line in said] == ["running identify"]
    assert (document.rms.translation or 0.0) > 1.5 * 16e-6  # joint 6 gives, and the model has no such joint


def test_a_comment_in_the_model_changes_nothing(campaign: Path) -> None:
    model = campaign / "model.toml"
    model.write_text("# looked at on Monday\n" + model.read_text())
    said: list[str] = []
    validate_campaign(campaign, means_with(said))
    assert said == []


def test_changed_thresholds_judge_again_without_fitting(campaign: Path) -> None:
    manifest = campaign / "campaign.toml"
    manifest.write_text(manifest.read_text() + "\n[thresholds]\nmax_rms_m = 1e-6\n")
    said: list[str] = []
    document = validate_campaign(campaign, means_with(said))
    assert said == []
    assert document.passed is False
    assert "max_rms_m" in document.failed[0]


def test_min_stiffness_is_held_joint_by_joint(campaign: Path) -> None:
    manifest = campaign / "campaign.toml"
    manifest.write_text(manifest.read_text() + "\n[thresholds]\nmin_stiffness = { A1 = 1e5, A6 = 5e4 }\n")
    failed = validate_campaign(campaign).failed
    assert len(failed) == 1
    assert "A6" in failed[0]


def test_a_copied_campaign_keeps_its_results(campaign: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copytree(campaign, tmp_path / "copy", symlinks=True))
    said: list[str] = []
    identify_campaign(copy, means_with(said, update=False))
    assert said == ["nothing has changed since fit 1"]


def test_store_elsewhere(campaign: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    shutil.rmtree(campaign / "store")
    identify_campaign(campaign, RunContext(store=str(elsewhere)))
    assert open_store(campaign, RunContext(store=str(elsewhere))).exists
    assert not (campaign / "store").exists()


def test_the_fit_finds_the_true_stiffness(validated_folder: Path) -> None:
    fit = identify_campaign(validated_folder, RunContext(update=False))
    found = np.array([parameter.stiffness for parameter in fit.parameters])
    std = np.array([parameter.stiffness_std for parameter in fit.parameters])
    assert np.all(np.abs(found - STIFFNESS) < 4.0 * std)
    assert fit.expected_rms is not None
    assert (fit.expected_rms.translation or 1.0) < 30e-6
    assert "in new poses" in fit.expected_error


def test_the_table_key_follows_the_values_not_their_chunks(validated_folder: Path) -> None:
    import pyarrow as pa

    table = up_to_date_states(validated_folder, RunContext()).table
    pieces = pa.concat_tables([table.slice(0, 3), table.slice(3)])
    assert key_of_table(pieces) == key_of_table(table)
    assert key_of_table(table.slice(1)) != key_of_table(table)


def test_another_campaigns_model_is_judged_here(campaign: Path, tmp_path: Path) -> None:
    other = write_small_campaign(tmp_path / "other", seed=7, poses=3)
    with pytest.raises(InputError, match="that campaign has no fitted model"):
        validate_campaign(campaign, model=other)
    identify_campaign(other)
    document = validate_campaign(campaign, model=other)
    assert document.scheme == "other campaign's model"
    assert (document.rms.translation or 1.0) < 40e-6
    # the verdict on another's model is not this campaign's own
    assert validate_campaign(campaign).scheme == "leave-one-pose-out"


def test_unknown_loss_is_refused(campaign: Path) -> None:
    with pytest.raises(InputError, match="unknown loss cubic"):
        identify_campaign(campaign, loss="cubic")


def test_another_loss_is_another_fit(campaign: Path) -> None:
    assert identify_campaign(campaign, loss="huber").fit_id == "2"
    # validate takes the fit that stands, robust or not
    assert validate_campaign(campaign, RunContext(update=False)).fit_id == "2"
