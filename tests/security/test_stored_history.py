"""A history that a stranger wrote: its fits are marked, and a model of it is restored only after a look."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stiffcal.cli.app import main
from stiffcal.commands.history import read_history, restore_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.stages.steps import RunContext
from tests.laboratory.delivered_store import forge


def test_history_of_a_stranger_is_kept_entry_by_entry_and_marked(delivered: Path) -> None:
    forge(delivered, "history", lambda document: document["fits"][0].update(origin="own", loss="huber"))
    assert [fit["origin"] for fit in document_of(read_history(delivered))["fits"]] == ["foreign"]
    validate_campaign(delivered)
    fits = document_of(read_history(delivered))["fits"]
    assert [(fit["id"], fit["origin"], fit["loss"]) for fit in fits] == [
        ("1", "foreign", "huber"),
        ("2", "own", "linear"),
    ]
    (delivered / "model.toml").write_text(
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [2, 3]\n'
    )
    identify_campaign(delivered)
    assert [fit["origin"] for fit in document_of(read_history(delivered))["fits"]] == ["foreign", "own", "own"]


@pytest.mark.parametrize(
    "entry",
    [{}, {"id": "9" * 5000}, {"id": 7}, {"id": "../1"}, {"model": 3}, {"model": {"balance": "x", "effects": None}},
     {"fit_rms": None}, {"time": None}, {"model_text": []}, {"heldout_rms": {"translation": "1"}}],
)  # fmt: skip
def test_an_entry_of_the_wrong_shape_harms_nothing(delivered: Path, entry: dict[str, Any]) -> None:
    def add(document: dict[str, Any]) -> None:
        document["fits"].append(document["fits"][0] | {"id": "2"} | entry if entry else "no entry")

    forge(delivered, "history", add)
    assert [fit["id"] for fit in document_of(read_history(delivered))["fits"]] == ["1"]
    assert identify_campaign(delivered).fit_id.isdigit()


def test_restoring_a_strangers_model_shows_it_and_asks(
    delivered: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (delivered / "model.toml").unlink()
    text = 'schema = "stiffcal/model/1"\n# \u202e\n[[effects]]\ntype = "joint-compliance"\njoints = [2]\n'
    forge(delivered, "history", lambda document: document["fits"][0].update(model_text=text))
    with pytest.raises(InputError, match="history: fit 1: this fit was not computed by you"):
        restore_model(delivered, RunContext(), "1")
    for words, code in (([], 2), (["--json"], 2), (["--yes"], 0)):
        with pytest.raises(SystemExit) as ended:
            main(["history", str(delivered), "--restore", "1", *words])
        error = capsys.readouterr().err
        assert ended.value.code == code
        assert "joints = [2]" in error
        assert "\u202e" not in error
        assert (delivered / "model.toml").exists() == (code == 0)
    assert (delivered / "model.toml").read_text("utf-8") == text


def test_restoring_what_is_no_model_is_one_line(delivered: Path) -> None:
    (delivered / "model.toml").unlink()
    forge(delivered, "history", lambda document: document["fits"][0].update(model_text="[[effects]]\ntype = 7\n"))
    with pytest.raises(InputError, match=r"model\.toml"):
        restore_model(delivered, RunContext(), "1", lambda entry: True)
    assert not (delivered / "model.toml").exists()
