"""The JSON Schemas of the documents: equal to the types, and true of what the commands answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from stiffcal.cli.app import main
from stiffcal.workflow.documents import DOCUMENTS, schema_texts

SCHEMAS = Path(__file__).parents[2] / "schemas"


@pytest.mark.parametrize("name", sorted(schema_texts()))
def test_schemas_are_those_of_the_types(name: str) -> None:
    text = schema_texts()[name]
    jsonschema.Draft202012Validator.check_schema(json.loads(text))
    # renewed by: python -m stiffcal.workflow.documents schemas/
    assert (SCHEMAS / name).read_text(encoding="utf-8") == text


WORDS: dict[str, list[str]] = {
    "identify": ["identify", "{}"],
    "validate": ["validate", "{}"],
    "history": ["history", "{}"],
    "ingest": ["ingest", "{}"],
    "predict": ["predict", "{}", "--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0"],
    "error": ["identify", "{}/nowhere"],
    "check": ["check", "{}"],
    "diagnose": ["diagnose", "{}"],
    "improve": ["improve", "{}", "--dry-run"],
    "compare": ["compare", "{}", "{}"],
    "run": ["run", "{}"],
    "report": ["report", "{}", "-o", "{}/report.pdf"],
    "plot": ["plot", "{}", "-o", "{}/plot.svg"],
    "export": ["export", "{}", "-o", "{}/states.csv"],
    "edit": ["add", "{}", "backlash", "--joints", "4"],
    "effects": ["effects", "backlash"],
    "init": ["init", "{}/new"],
    "simulate": ["simulate", "{}/twin", "--from", str(SCHEMAS.parent / "campaigns" / "irb4400")],
}


def answer(capsys: pytest.CaptureFixture[str], folder: Path, name: str) -> dict[str, Any]:
    with pytest.raises(SystemExit):
        main([*(word.format(folder) for word in WORDS[name]), "--json"])
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    return document


@pytest.mark.parametrize("name", sorted(DOCUMENTS))
def test_answers_hold_to_their_schema(name: str, campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    schema = json.loads(schema_texts()[f"{name}.document.schema.json"])
    document = answer(capsys, campaign, name)
    jsonschema.validate(document, schema)
    # and the schema is no empty promise
    for key in schema["required"]:
        broken = {other: value for other, value in document.items() if other != key}
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(broken, schema)
