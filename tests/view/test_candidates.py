"""How sure the page calls each candidate: as sure as the sentence above it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.diagnosis.answers.results import DiagnoseResult, ExcludedSizeAt, LookAlike
from stiffcal.model.summary import Where
from stiffcal.stages.diagnoses.current import current_diagnosis
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.view.content import ViewModel
from stiffcal.view.gathering.candidates import in_model_in_words, sizes_in_words, view_candidates
from stiffcal.view.gathering.change import LastAdded
from stiffcal.wording import length, probability_in_words
from tests.laboratory.diagnosed_folders import WITHOUT_6, diagnosed_copy


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory: pytest.TempPathFactory) -> DiagnoseResult:
    folder, context = diagnosed_copy(WITHOUT_6, tmp_path_factory.mktemp("candidates") / "small"), RunContext()
    data = up_to_date_states(folder, context)
    found, _ = current_diagnosis(data, up_to_date_fit(data, context))
    assert found is not None
    return found


def test_members_of_a_group_have_the_probabilities_of_the_verdict(diagnosis: DiagnoseResult) -> None:
    (missing,) = diagnosis.missing
    rival = LookAlike(effect="bearing-tilt", where=Where(joints=[6]), probability=0.25)
    group = replace(missing, probability=0.8, member_probability=0.5, alternatives=[rival])
    sure = {one.name: one.sure for one in view_candidates(replace(diagnosis, missing=[group]))}
    assert sure["joint-compliance j6"] == probability_in_words(0.4)
    assert sure["bearing-tilt j6"] == probability_in_words(0.2)


def test_once_in_the_model_an_effect_keeps_its_probability_and_its_look_alikes(diagnosis: DiagnoseResult) -> None:
    (missing,) = diagnosis.missing
    rival = LookAlike(effect="bearing-tilt", where=Where(joints=[6]), probability=0.25)
    group = replace(missing, probability=0.8, member_probability=0.75, alternatives=[rival])
    words = in_model_in_words(replace(diagnosis, missing=[], in_model=[group]))
    assert f"joint-compliance of joint 6 {probability_in_words(0.6)}" in words
    assert f"bearing-tilt of joint 6 {probability_in_words(0.2)}" in words
    assert in_model_in_words(diagnosis) == ""


def test_where_nothing_is_found_the_page_states_what_would_have_been(diagnosis: DiagnoseResult) -> None:
    size = ExcludedSizeAt(where=Where(joints=[3]), of="joint 3", size_m=2e-5, effect="backlash")
    silent = replace(diagnosis, missing=[], unexplained=False, excluded_sizes=[size])
    assert f"joint 3: {length(2e-5)} (backlash)." in sizes_in_words(silent)
    assert sizes_in_words(replace(silent, missing=diagnosis.missing)) == ""


def test_what_is_rejected_has_none(diagnosis: DiagnoseResult) -> None:
    found = view_candidates(diagnosis)
    assert found[0].sure
    assert {one.sure for one in found if one.standing == "rejected"} == {""}


def test_before_and_after_are_shown_though_nothing_explains_what_is_left() -> None:
    before = ViewModel(id="fit1", kind="fit", label="", short="", residual_fit=np.zeros((1, 3)))
    change = LastAdded(before="fit1", names=["link-springs arm"]).change([before], [])
    assert change is not None
    assert (change.before, change.variable) == ("fit1", "")
