"""The JSON Schemas lie in schemas/ as the types make them, and accept what the loader accepts."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from stiffcal.campaign.schemas import SCHEMAS, schema_document, schema_text, write_schemas

ROOT = Path(__file__).parents[2]
CAMPAIGNS = ROOT / "campaigns"


@pytest.mark.parametrize("name", SCHEMAS)
def test_schema_is_up_to_date(name: str) -> None:
    text = (ROOT / "schemas" / name).read_text(encoding="utf-8")
    assert text == schema_text(SCHEMAS[name]()), "run: python -m stiffcal.campaign.schemas schemas"


def test_writing_makes_all(tmp_path: Path) -> None:
    assert {path.name for path in write_schemas(tmp_path / "schemas")} == set(SCHEMAS)


@pytest.mark.parametrize("name", SCHEMAS)
def test_schema_is_a_schema(name: str) -> None:
    jsonschema.Draft202012Validator.check_schema(schema_document(SCHEMAS[name]()))
    assert '"null"' not in schema_text(SCHEMAS[name]())


def _validator(name: str) -> Any:
    return jsonschema.Draft202012Validator(json.loads((ROOT / "schemas" / name).read_text(encoding="utf-8")))


@pytest.mark.parametrize("name", ["campaign", "robot"])
def test_bundled_files_fit_the_schema(name: str) -> None:
    validator = _validator(f"{name}.schema.json")
    files = sorted(path for path in CAMPAIGNS.rglob(f"{name}.toml"))
    assert len(files) > 20
    for file in files:
        validator.validate(tomllib.loads(file.read_text(encoding="utf-8")))


def test_schema_refuses_what_the_loader_refuses() -> None:
    validator = _validator("campaign.schema.json")
    document = {"schema": "stiffcal/campaign/1", "sources": {"ft": {"wrench": {"colums": ["Fx"]}}}}
    assert not validator.is_valid(document)
    document["sources"] = {"ft": {"wrench": {"columns": "F1..F3", "axes": "base", "point": "tool"}}}
    assert validator.is_valid(document)


def test_properties_carry_the_words_of_the_docstrings() -> None:
    frame = schema_document(SCHEMAS["campaign.schema.json"]())["$defs"]["Frame"]
    assert frame["properties"]["estimate"]["description"].startswith("found from the unloaded poses")
