"""The practice campaigns of absolute places: what is named, against what is hidden in them."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stiffcal.commands.improve import improve_campaign
from stiffcal.stages.steps import RunContext
from tests.laboratory.once import once
from tests.laboratory.practice_marks import with_practice
from tests.rates.practice import ABSOLUTE, Answer, ask, truth

NAMES = sorted(truth(ABSOLUTE))


def answer_of(name: str) -> Answer:
    """Return the search's answer for one campaign, asked once in a session."""
    return once(ask, ABSOLUTE / name)


# Here nothing is hidden, or an encoder that is not centred.
@pytest.mark.parametrize("name", with_practice(NAMES, "01", "04"))
def test_names_what_is_hidden(name: str) -> None:
    answer = answer_of(name)
    assert answer.right, f"{answer.hidden or 'nothing'} is hidden, {answer.named or 'nothing'} is named"


@pytest.mark.parametrize("name", with_practice(["02", "03", "04", "05", "06"], "04"))
def test_the_first_name_or_its_look_alike_is_hidden(name: str) -> None:
    answer = answer_of(name)
    assert answer.hidden in answer.named.split(" + ")[0]


@pytest.mark.parametrize("name", with_practice(["01", "02", "03", "04", "05", "06"], "01", "04"))
def test_errors_in_regions_left_out_are_within_fifteen_percent_of_the_noise(name: str) -> None:
    """A refit of the true effects errs by at least the noise: this is closer than within 15 % of that refit."""
    assert answer_of(name).after < 1.15


# Where something is outside the catalogue, joints/05 is improved.
@pytest.mark.practice
@pytest.mark.parametrize("name", ["01", "07"])
def test_nothing_is_added_or_removed_where_no_effect_of_the_catalogue_is_hidden(name: str, tmp_path: Path) -> None:
    """Frames to be estimated are no effects of the model file, and geometry belongs to every model of such places."""
    folder = shutil.copytree(ABSOLUTE / name, tmp_path / name, ignore=shutil.ignore_patterns("store"))
    improved = improve_campaign(folder, RunContext())
    assert [step.action for step in improved.steps] == ["start"]
    assert improved.unexplained is truth(ABSOLUTE)[name]["outside_the_catalogue"]


def test_campaigns_are_whole() -> None:
    assert len(NAMES) == 7
    for name in NAMES:
        files = {path.name for path in (ABSOLUTE / name).iterdir()}
        assert files >= {"campaign.toml", "model.toml", "robot.toml", "raw"}
        assert (ABSOLUTE / name / "raw" / "poses.csv").is_file()
