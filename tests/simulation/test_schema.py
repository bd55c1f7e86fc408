"""The JSON Schema of simulate.toml is what the types make, and accepts what the loader accepts."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from stiffcal.simulation.schema import FILE, simulate_schema_text

ROOT = Path(__file__).parents[2]
VALID = {"schema": "stiffcal/simulate/1", "runs": [{"id": "a", "joints_deg": [0.0]}]}


def test_schema_is_up_to_date() -> None:
    text = (ROOT / "schemas" / FILE).read_text(encoding="utf-8")
    assert text == simulate_schema_text(), "run: python -m stiffcal.simulation.schema schemas"
    jsonschema.Draft202012Validator.check_schema(json.loads(text))
    assert '"null"' not in text


@pytest.mark.parametrize(
    "file", sorted((ROOT / "campaigns").glob("**/simulate.toml")), ids=lambda file: file.parent.name
)
def test_simulated_campaigns_fit_the_schema(file: Path) -> None:
    jsonschema.validate(tomllib.loads(file.read_text(encoding="utf-8")), json.loads(simulate_schema_text()))


@pytest.mark.parametrize(
    "wrong",
    [
        {"sensors": {"ft": {"white": {"force": 1.0}}}},
        {"loads": {"cycles": 0}},
        {"loads": {"directions": [[0.0, 1.0]]}},
        {"runs": []},
        {"seed": -1},
    ],
)
def test_schema_refuses_what_the_loader_refuses(wrong: dict[str, object]) -> None:
    validator = jsonschema.Draft202012Validator(json.loads(simulate_schema_text()))
    assert validator.is_valid(VALID)
    assert not validator.is_valid(VALID | wrong)
