"""The ladder of fits and the way back."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.history import read_history, restore_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.model.summary import EffectInModel, ModelSummary
from stiffcal.stages.steps import RunContext


def test_validate_completes_the_entry(campaign: Path) -> None:
    (fit,) = document_of(read_history(campaign))["fits"]
    assert fit["id"] == "1"
    assert fit["heldout_rms"]["translation"] > fit["fit_rms"]["translation"] > 0.0
    assert fit["model"]["effects"] == [{"type": "joint-compliance", "joints": [1, 2, 3, 4, 5, 6]}]


def test_an_edited_model_is_not_fitted_yet(campaign: Path) -> None:
    edit_model(campaign, "remove", "joint-compliance", where={"joints": "6"})
    document = document_of(read_history(campaign))
    assert document["not_fitted_yet"]["effects"][0]["joints"] == [1, 2, 3, 4, 5]
    assert document["warnings"] == ["the model in model.toml is not fitted yet"]
    identify_campaign(campaign)
    document = document_of(read_history(campaign))
    assert "not_fitted_yet" not in document
    assert [fit["heldout_rms"] is None for fit in document["fits"]] == [False, True]


def test_restore_brings_the_model_back_with_its_comments(campaign: Path) -> None:
    before = (campaign / "model.toml").read_text()
    edit_model(campaign, "remove", "joint-compliance", where={"joints": "A6"})
    assert (campaign / "model.toml").read_text() != before
    restore_model(campaign, RunContext(), "1")
    assert (campaign / "model.toml").read_text() == before
    assert "not_fitted_yet" not in document_of(read_history(campaign))


def test_restore_where_the_default_model_held(campaign: Path) -> None:
    (campaign / "model.toml").unlink()
    identify_campaign(campaign)
    edit_model(campaign, "remove", "joint-compliance", where={"joints": "6"})
    identify_campaign(campaign)
    restore_model(campaign, RunContext(), document_of(read_history(campaign))["fits"][0]["id"])
    assert "joints" in (campaign / "model.toml").read_text()


def test_restore_of_an_unknown_fit(campaign: Path) -> None:
    with pytest.raises(InputError, match="there is no fit 9; known: 1"):
        restore_model(campaign, RunContext(), "9")


def test_models_are_the_same_in_any_order() -> None:
    backlash, drive = EffectInModel("a", joints=[1, 2]), EffectInModel("b", pairs=[[5, 6]])
    first = ModelSummary("deformed", [backlash, drive])
    assert first.same_as(ModelSummary("deformed", [drive, EffectInModel("a", joints=[2, 1])]))
    assert not first.same_as(ModelSummary("first-order", [backlash, drive]))
