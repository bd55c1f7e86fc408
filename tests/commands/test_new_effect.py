"""`effects new`: the plugin that tests what nothing in the catalogue accounts for."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from stiffcal.campaign.loading import load_campaign
from stiffcal.cli.app import main
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.new_effect import write_new_effect
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from tests.laboratory.small_campaign import write_small_campaign

SCHEMA = Path(__file__).parents[2] / "schemas" / "new-effect.document.schema.json"
HIDDEN = Path(__file__).parents[2] / "campaigns" / "hidden" / "09"


def run(*words: str) -> int:
    """Run a command, and return how it ended."""
    with pytest.raises(SystemExit) as raised:
        main(list(words))
    return int(raised.value.code or 0)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign in which nothing is hidden."""
    return write_small_campaign(tmp_path_factory.mktemp("new") / "plain")


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("backlash", "name-duplicate"),
        ("../out", "name-invalid"),
        ("Own", "name-invalid"),
        ("a" * 41, "name-invalid"),
        ("json", "plugin-invalid"),
        ("sound-effect", "data-missing"),
    ],
)
def test_what_cannot_be_written_leaves_the_folder_as_it_was(plain: Path, name: str, code: str) -> None:
    manifest = (plain / "campaign.toml").read_bytes()
    with pytest.raises(InputError) as raised:
        write_new_effect(plain, name)
    assert raised.value.faults[0].code.value == code
    assert (plain / "campaign.toml").read_bytes() == manifest
    assert not list(plain.glob("*.py"))


def test_no_file_is_replaced(plain: Path) -> None:
    own = plain / "own_effect.py"
    own.write_text("# mine\n", encoding="utf-8")
    with pytest.raises(InputError) as raised:
        write_new_effect(plain, "own-effect")
    assert raised.value.faults[0].code.value == "file-exists"
    assert own.read_text(encoding="utf-8") == "# mine\n"
    own.unlink()


@pytest.mark.parametrize("words", [["new"], ["new", "own"], ["backlash", "own"]])
def test_the_command_line_asks_for_what_is_missing(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run("effects", *words) == 2
    assert "effects new NAME --from DIR" in capsys.readouterr().err


@pytest.mark.practice
def test_what_none_of_the_catalogue_explains_is_explained_by_the_effect_that_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Practice 09 hides a compliance of joint 2 that follows the angle of joint 1."""
    folder = shutil.copytree(HIDDEN, tmp_path / "09")
    assert run("diagnose", str(folder)) == 0
    captured = capsys.readouterr()
    assert "next: stiffcal effects new compliance-over-angle-1 --from" in captured.out + captured.err
    assert run("effects", "new", "follows-one", "--from", str(folder), "--json") == 0
    document = json.loads(capsys.readouterr().out)
    Draft202012Validator(json.loads(SCHEMA.read_text(encoding="utf-8"))).validate(document)
    assert (document["effect"], document["file"]) == ("follows-one", "follows_one.py")
    assert load_campaign(folder).manifest.plugins == ("follows_one.py",)
    assert run("trust", str(folder), "--yes") == 0
    # that a diagnosis then names it is shown, of the same campaign, by docs/how-to/own-effect-proposed.md
    before = validate_campaign(folder)
    edit_model(folder, "add", "follows-one", where={"joints": "2"})
    after = validate_campaign(folder)
    assert before.rms.translation is not None
    assert after.rms.translation is not None
    assert after.noise is not None
    assert after.noise.translation is not None
    assert after.rms.translation < 1.05 * after.noise.translation < before.rms.translation
