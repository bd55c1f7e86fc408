"""Models that a page tries: any choice is what `add`, `remove`, `[[exclude]]` and `identify` make of a campaign."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import Progress
from stiffcal.identification.answers.before_after import estimated_parameters
from stiffcal.live.choice import ModelChoice, RowsLeftOut
from stiffcal.live.models import OF_ANOTHER_PAGE, LiveModels, ModelChangedError, SupersededError
from stiffcal.stages.steps import RunContext
from stiffcal.view.content import ViewModel
from tests.laboratory.few_effects import few_effects


@pytest.fixture
def models(campaign: Path) -> LiveModels:
    return LiveModels(campaign, RunContext())


@pytest.fixture
def of_few_effects() -> Iterator[None]:
    """A diagnosis in a third of the time: which effects it compares matters to no test here."""
    with few_effects():
        yield


def _shown(models: LiveModels, choice: ModelChoice) -> ViewModel:
    return next(model for model in models.content(choice).models if model.present)


CHOICES = {
    "added": ModelChoice(added=["bearing-tilt j2"]),
    "two added": ModelChoice(added=["backlash j3", "bearing-tilt j1"]),
    "removed": ModelChoice(removed=["joint-compliance j6"]),
    "exchanged": ModelChoice(added=["joint-full j2"], removed=["joint-compliance j5"]),
    "rows left out": ModelChoice(added=["bearing-tilt j2"], excluded=[RowsLeftOut(source="table", rows=[3, "7-9"])]),
}


@pytest.mark.parametrize("choice", CHOICES.values(), ids=CHOICES.keys())
def test_any_choice_is_what_the_commands_make(
    models: LiveModels, campaign: Path, tmp_path: Path, choice: ModelChoice
) -> None:
    tried = _shown(models, choice)
    other = Path(shutil.copytree(campaign, tmp_path / "other", ignore=shutil.ignore_patterns("store")))
    for name in choice.removed:
        edit_model(other, "remove", name.split()[0], where={"joints": name.split()[1][1:]})
    for name in choice.added:
        edit_model(other, "add", name.split()[0], where={"joints": name.split()[1][1:]})
    with (other / "campaign.toml").open("a") as file:
        file.write("".join(f"\n{one.as_toml()}\n" for one in choice.excluded))
    fitted, judged = identify_campaign(other), validate_campaign(other)
    assert tried.fit_rms == fitted.rms
    assert tried.heldout_rms == judged.rms
    expected = {entry.name: entry.value for entry in estimated_parameters(fitted.parameters)}
    assert {value.name: value.value for value in tried.values} == expected


def test_nothing_but_the_store_of_the_model_itself_is_written(models: LiveModels, campaign: Path) -> None:
    models.content(ModelChoice())
    before = {path: path.read_bytes() for path in campaign.rglob("*") if path.is_file()}
    models.content(CHOICES["two added"])
    models.content(CHOICES["rows left out"])
    assert {path: path.read_bytes() for path in campaign.rglob("*") if path.is_file()} == before


def test_a_choice_that_comes_back_is_not_fitted_again(models: LiveModels, monkeypatch: pytest.MonkeyPatch) -> None:
    first = _shown(models, CHOICES["added"])
    models.content(ModelChoice())
    monkeypatch.setattr("stiffcal.stages.fit.fit_now", lambda *given: pytest.fail("fitted again"))
    again = _shown(models, CHOICES["added"])
    assert again.id == first.id
    assert again.heldout_rms == first.heldout_rms


def test_a_model_that_is_tried_has_no_log_looked_at(models: LiveModels, monkeypatch: pytest.MonkeyPatch) -> None:
    first = models.content(ModelChoice())
    monkeypatch.setattr("stiffcal.view.gathering.runs.place_of_row", lambda *given: pytest.fail("looked at"))
    assert first.runs[0].first_row
    assert [run.first_row for run in models.content(CHOICES["removed"]).runs] == [run.first_row for run in first.runs]


def test_the_ladder_holds_what_was_tried(models: LiveModels) -> None:
    models.content(CHOICES["added"])
    content = models.content(CHOICES["removed"])
    labels = [model.label for model in content.models if model.id.startswith("tried")]
    assert labels == ["tried: + bearing-tilt j2", "tried: − joint-compliance j6"]
    assert len({model.id for model in content.models}) == len(content.models)
    assert all(model.residual_heldout is not None for model in content.models if model.id.startswith("tried"))

    left_out = ModelChoice(excluded=[RowsLeftOut(source="table", rows=[3, "7-9"])])
    assert left_out.label == "without 4 rows"


def test_what_lowers_no_error_is_said_to(models: LiveModels) -> None:
    """On a robot of joint springs alone a tilt gains next to nothing; the model of the file is compared with none."""
    remarks = [_shown(models, choice).remark for choice in (ModelChoice(), CHOICES["two added"], CHOICES["removed"])]
    assert [bool(remark) for remark in remarks] == [False, True, False]


def test_a_forecast_is_near_the_refit(models: LiveModels) -> None:
    assert models.forecast(CHOICES["added"]) is None  # nothing is prepared yet
    assert models.prepare()
    for choice in (CHOICES["added"], CHOICES["removed"], CHOICES["exchanged"]):
        found, refit = models.forecast(choice), _shown(models, choice)
        forecast = None if found is None else found.models[0]
        if forecast is None:
            assert choice is CHOICES["exchanged"]  # it takes out what joint-full includes: not one step
            continue
        assert forecast.residual_heldout is not None
        assert refit.residual_heldout is not None
        assert forecast.residual_heldout.shape == refit.residual_heldout.shape
        assert forecast.heldout_rms is not None
        assert refit.heldout_rms is not None
        # one linear step: second order in what it changes
        assert forecast.heldout_rms.translation == pytest.approx(refit.heldout_rms.translation, rel=0.1)
        size = np.sqrt(np.nanmean(refit.residual_heldout**2))
        assert np.sqrt(np.nanmean((forecast.residual_heldout - refit.residual_heldout) ** 2)) < 0.3 * size


def test_writing_is_adding(models: LiveModels, campaign: Path, tmp_path: Path) -> None:
    other = Path(shutil.copytree(campaign, tmp_path / "other"))
    edit_model(other, "add", "bearing-tilt", where={"joints": "2"})
    models.content(CHOICES["added"])
    models.write(CHOICES["added"])
    assert (campaign / "model.toml").read_text() == (other / "model.toml").read_text()
    assert [model.label for model in models.content(ModelChoice()).models if model.present] == [
        "fit 2: joint-compliance + bearing-tilt"
    ]


def test_a_changed_file_is_never_overwritten(models: LiveModels, campaign: Path) -> None:
    models.content(CHOICES["added"])
    edit_model(campaign, "add", "backlash", where={"joints": "3"})
    theirs = (campaign / "model.toml").read_text()
    with pytest.raises(ModelChangedError):
        models.write(CHOICES["added"])
    with pytest.raises(ModelChangedError):
        models.content(ModelChoice())
    assert (campaign / "model.toml").read_text() == theirs
    models.write(CHOICES["added"], to_changed_file=True)
    assert "backlash" in (campaign / "model.toml").read_text()
    assert "bearing-tilt" in (campaign / "model.toml").read_text()


@pytest.mark.long
@pytest.mark.usefixtures("of_few_effects")
def test_what_was_diagnosed_is_diagnosed_once_it_is_written(models: LiveModels, campaign: Path) -> None:
    tried = models.diagnose(CHOICES["added"])
    models.write(CHOICES["added"])
    written = models.content(ModelChoice())
    assert written.is_diagnosed
    assert not written.diagnosis_of
    assert written.verdict == tried.verdict
    assert written.candidates == tried.candidates
    # the commands know it too: nothing is diagnosed again, and it is of the present fit
    again = diagnose_campaign(campaign)
    assert again.summary == tried.verdict
    assert again.fit_id == written.fit_id


@pytest.mark.usefixtures("of_few_effects")
def test_a_written_model_shows_the_diagnosis_of_the_one_before(models: LiveModels) -> None:
    judged = models.diagnose(ModelChoice())
    models.content(CHOICES["added"])
    models.write(CHOICES["added"])
    written = models.content(ModelChoice())
    assert (judged.diagnosis_of, written.diagnosis_of != "") == ("", True)
    assert written.verdict == judged.verdict


@pytest.mark.usefixtures("of_few_effects")
def test_tried_models_stand_after_the_fits(models: LiveModels) -> None:
    models.diagnose(ModelChoice())
    models.content(CHOICES["added"])
    kinds = [
        ("tried" if model.id.startswith("tried") else model.kind) for model in models.content(ModelChoice()).models
    ]
    assert kinds[:2] == ["fit", "tried"]
    assert "tried" not in kinds[2:]


def test_what_is_done_is_of_what_a_page_asked_for_last(models: LiveModels) -> None:
    models._latest["one"] = -1
    models._doing = ("one", -1, "preparing forecasts", 0.5)
    before = models.doing("one")
    models.leave("one")  # as another request does: what was begun before it ends still
    assert [before[:2], models.doing("one")] == [("preparing forecasts", 0.5), ("", None, "")]
    assert models.doing("other") == (OF_ANOTHER_PAGE, None, "")


def test_a_page_ends_what_it_asked_for_itself_and_waits_for_others(models: LiveModels) -> None:
    """Two pages on one server: a request of one must not end that of the other, which would wait for ever."""
    progress: list[Progress] = []

    def long(report: Progress) -> str:
        progress.append(report)
        models.leave("two")
        report("fitting", 0.5)  # the other page ends nothing here
        models._latest["one"] += 1  # as a second request of this page does
        with pytest.raises(SupersededError):
            report("fitting", 0.6)
        return "done"

    assert models._alone(long, "one") == "done"
    assert len(progress) == 1
