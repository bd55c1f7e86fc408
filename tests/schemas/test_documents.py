"""The JSON Schemas of the documents: equal to the types, and true of what the commands answer."""

from __future__ import annotations

import json
import shutil
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from stiffcal.cli.app import main
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import Progress
from stiffcal.report.content import ReportContent
from stiffcal.schemas.documents import DOCUMENTS, schema_texts
from tests.laboratory.small_campaign import write_small_campaign

SCHEMAS = Path(__file__).parents[2] / "schemas"


@cache
def texts() -> dict[str, str]:
    """Return `schema_texts()`, made once."""
    return schema_texts()


@pytest.mark.parametrize("name", sorted(DOCUMENTS))
def test_schemas_are_those_of_the_types(name: str) -> None:
    file = f"{name}.document.schema.json"
    jsonschema.Draft202012Validator.check_schema(json.loads(texts()[file]))
    # renewed by: python -m stiffcal.schemas.documents schemas/
    assert (SCHEMAS / file).read_text(encoding="utf-8") == texts()[file]


pytestmark = pytest.mark.usefixtures("few_known_effects")
WORDS: dict[str, list[str]] = {
    "doctor": ["doctor"],
    "identify": ["identify", "{}"],
    "validate": ["validate", "{}"],
    "history": ["history", "{}"],
    "ingest": ["ingest", "{}"],
    "predict": ["predict", "{}", "--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0"],
    "plan": ["plan", "{}", "--force", "300", "--runs", "4", "-o", "{}/runs.csv"],
    "map": ["map", "{}", "--load", "0,0,-100", "--points", "4"],
    "compensate": ["compensate", "{}", "--path", "{}/path.csv"],
    "error": ["identify", "{}/nowhere"],
    "check": ["check", "{}"],
    "diagnose": ["diagnose", "{}"],
    "improve": ["improve", "{}", "--dry-run"],
    "compare": ["compare", "{}", "{}"],
    "trend": ["trend", "{}", "{}"],
    "run": ["run", "{}"],
    "batch": ["batch", "{}", "--no-report"],
    "report": ["report", "{}", "-o", "{}/report.pdf"],
    "plot": ["plot", "{}", "-o", "{}/plot.svg"],
    "view": ["view", "{}", "-o", "{}/view.html"],
    "export": ["export", "{}", "-o", "{}/states.csv"],
    "edit": ["add", "{}", "backlash", "--joints", "4"],
    "effects": ["effects", "backlash"],
    "trust": ["trust", "{}"],
    "init": ["init", "{}/new"],
    "simulate": ["simulate", "{}/twin", "--from", str(SCHEMAS.parent / "campaigns" / "irb4400")],
}


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign for all commands here, every result in its store: its answers are checked, not how it was made."""
    folder = write_small_campaign(tmp_path_factory.mktemp("documents") / "small", poses=3)
    (folder / "path.csv").write_text("A1,A2,A3,A4,A5,A6,Fz\n-30,-70,20,15,40,10,-300\n")
    validate_campaign(folder)
    diagnose_campaign(folder)
    return folder


@pytest.fixture
def folder(diagnosed: Path, request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """That campaign; a copy for the command that changes the model."""
    if request.node.callspec.params["name"] == "edit":
        return Path(shutil.copytree(diagnosed, tmp_path / "small", symlinks=True))
    return diagnosed


@pytest.fixture
def unprinted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pages away: ten seconds each time, and `tests/report` reads them."""

    def touch(content: ReportContent, output: Path, progress: Progress, is_short: bool) -> None:
        output.write_bytes(b"")

    monkeypatch.setattr("stiffcal.report.building.build_report", touch)


def answer(capsys: pytest.CaptureFixture[str], folder: Path, name: str) -> dict[str, Any]:
    with pytest.raises(SystemExit):
        main([*(word.format(folder) for word in WORDS[name]), "--json"])
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    return document


# A new effect takes a campaign that no effect explains: `tests/commands/test_new_effect.py` judges its answer; a live
# page is served until its user ends it: `tests/live/test_command.py`.
@pytest.mark.usefixtures("unprinted")
@pytest.mark.parametrize("name", sorted(DOCUMENTS.keys() - {"new-effect", "live"}))
def test_answers_hold_to_their_schema(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    schema = json.loads(texts()[f"{name}.document.schema.json"])
    held = jsonschema.Draft202012Validator(schema)
    document = answer(capsys, folder, name)
    held.validate(document)
    # and the schema is no empty promise
    for key in schema["required"]:
        assert not held.is_valid({other: value for other, value in document.items() if other != key})
