"""`add` and `remove`: places in words, comments kept, errors that list the places."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.model import model_editing
from stiffcal.commands.edit_model import edit_model, start_values
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.model.assembled.assembly import compliant_robot
from stiffcal.model.catalogue.catalogue import find_effects


def test_remove_and_add_back_keeps_comments(campaign: Path) -> None:
    edit_model(campaign, "remove", "joint-compliance", where={"joints": "A2,6"})
    document = document_of(edit_model(campaign, "add", "joint-compliance", where={"joints": "2,A6"}))
    (effect,) = document["model"]["effects"]
    assert sorted(effect["joints"]) == [1, 2, 3, 4, 5, 6]
    text = (campaign / "model.toml").read_text()
    assert "# the drives, and nothing else" in text
    assert "# one spring each" in text


def test_all_adds_every_place(campaign: Path) -> None:
    edit_model(campaign, "remove", "joint-compliance", where={"joints": "1,2,3"})
    document = document_of(edit_model(campaign, "add", "joint-compliance", everywhere=True))
    assert document["changes"] == ["added joint-compliance: j1, j2, j3"]


def test_adding_what_is_there_changes_nothing(campaign: Path) -> None:
    before = (campaign / "model.toml").read_text()
    document = document_of(edit_model(campaign, "add", "joint-compliance", where={"joints": "1"}))
    assert "nothing changed" in document["changes"][0]
    assert (campaign / "model.toml").read_text() == before


@pytest.mark.parametrize(
    ("effect", "where", "message"),
    [
        ("joint-compliance", {}, r"none is given; give --joints with one or more of 1, 2, 3, 4, 5, 6, or --all"),
        ("joint-complience", {"joints": "1"}, "did you mean joint-compliance"),
        ("joint-compliance", {"joints": "7"}, "unknown joint 7"),
        ("joint-compliance", {"links": "swing"}, "use --joints instead"),
        ("thermal-drift", {"joints": "2"}, "leave the place out"),
    ],
)
def test_what_cannot_be_added(campaign: Path, effect: str, where: dict[str, str], message: str) -> None:
    before = (campaign / "model.toml").read_text()
    with pytest.raises(InputError, match=message):
        edit_model(campaign, "add", effect, where=where)
    assert (campaign / "model.toml").read_text() == before


def test_removing_what_is_not_there(campaign: Path) -> None:
    edit_model(campaign, "remove", "joint-compliance", where={"joints": "4"})
    with pytest.raises(InputError, match="contains no joint-compliance at j4"):
        edit_model(campaign, "remove", "joint-compliance", where={"joints": "4"})


def test_springs_made_curved(campaign: Path) -> None:
    edit_model(campaign, "add", "bearing-tilt", where={"joints": "2,3"})
    document = document_of(edit_model(campaign, "add", "bearing-tilt", where={"joints": "3,4"}, curved=True))
    assert document["changes"] == ["added bearing-tilt: j4", "curved: j3, j4"]
    loaded = load_campaign(campaign, check_files=False)
    robot = compliant_robot(loaded.chain, loaded.model, find_effects())
    symbols = {one.place.label: [spec.symbol for spec in one.effect.parameters] for one in robot.placed[6:]}
    assert symbols == {"j2": ["x", "y"], "j3": ["x", "x2", "x3", "y", "y2", "y3"], "j4": symbols["j3"]}
    assert (
        "nothing changed"
        in document_of(edit_model(campaign, "add", "bearing-tilt", where={"joints": "3"}, curved=True))["changes"][0]
    )
    edit_model(campaign, "remove", "bearing-tilt", where={"joints": "3"})
    assert "bearing-tilt.j3" not in (campaign / "model.toml").read_text()
    with pytest.raises(InputError, match="joint-compliance has no curved form"):
        edit_model(campaign, "add", "joint-compliance", everywhere=True, curved=True)


def test_start_values_choose_the_form(campaign: Path) -> None:
    """Torque over angle holds its own first slope: joint-compliance goes from that joint, and from no other."""
    start = {"p1": 3.6e5, "p2": -1.8e7, "p3": -8e9}
    changes = edit_model(campaign, "add", "cubic-stiffness", where={"joints": "2"}, start=start).changes
    assert "removed joint-compliance: j2 (cubic-stiffness includes it)" in changes
    model = load_campaign(campaign, check_files=False).model
    values = {name: setting.value for name, setting in model.parameter_settings().items()}
    assert values == {f"cubic-stiffness.j2.{symbol}": value for symbol, value in start.items()}
    with pytest.raises(InputError, match="no form with the parameters p4"):
        edit_model(campaign, "add", "cubic-stiffness", where={"joints": "3"}, start={"p4": 1.0})


def test_a_curve_that_is_removed_leaves_the_spring_that_it_held(campaign: Path) -> None:
    start = {"p1": 3.6e5, "p2": -1.8e7, "p3": -8e9}
    edit_model(campaign, "add", "cubic-stiffness", where={"joints": "2,4"}, start=start)
    changes = edit_model(campaign, "remove", "cubic-stiffness", where={"joints": "2"}).changes
    assert "added joint-compliance: j2 (it was a part of cubic-stiffness)" in changes
    edit_model(campaign, "remove", "cubic-stiffness", everywhere=True)
    (springs,) = load_campaign(campaign, check_files=False).model.effects
    assert (springs.type, sorted(springs.joints or ())) == ("joint-compliance", [1, 2, 3, 4, 5, 6])


def test_a_law_next_to_a_spring_is_removed_alone(campaign: Path) -> None:
    before = (campaign / "model.toml").read_text()
    edit_model(campaign, "add", "cubic-stiffness", where={"joints": "2"})
    edit_model(campaign, "remove", "cubic-stiffness", everywhere=True)
    assert (campaign / "model.toml").read_text().strip() == before.strip()


@pytest.mark.parametrize("text", ["p1", "p1=", "=3", "p1=x", "p1=nan"])
def test_a_start_value_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="not a start value"):
        start_values(text)


@pytest.mark.parametrize(("general", "included"), [("link-geometry", "joint-offset"), ("joint-full", "bearing-tilt")])
def test_what_the_model_includes_already_is_not_added(campaign: Path, general: str, included: str) -> None:
    edit_model(campaign, "add", general, where={"joints": "2,3"})
    before = (campaign / "model.toml").read_text()
    with pytest.raises(InputError, match=f"{general} in the model includes {included} at j3"):
        edit_model(campaign, "add", included, where={"joints": "3,4"})
    assert (campaign / "model.toml").read_text() == before
    edit_model(campaign, "add", included, where={"joints": "4"})


def test_a_model_file_is_written_once_however_many_changes_it_takes(
    campaign: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved: list[str] = []
    save = model_editing.save_model

    def counted(folder: Path, text: str) -> None:
        saved.append(text)
        save(folder, text)

    monkeypatch.setattr(model_editing, "save_model", counted)
    start = {"p1": 3.6e5, "p2": 0.0, "p3": 0.0}
    changes = edit_model(campaign, "add", "cubic-stiffness", where={"joints": "2"}, start=start).changes
    assert len(changes) == 2
    assert saved == [(campaign / "model.toml").read_text(encoding="utf-8")]
