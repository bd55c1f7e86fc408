"""The JSON Schemas of the store's tables: equal to what the code makes, and true of the tables of real stores."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pyarrow as pa
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.measurements.columns import values_of
from stiffcal.schemas.tables import schema_texts, table_schema
from stiffcal.store import Store
from tests.commands.test_improve import COUPLED
from tests.ingest.test_logged_runs import GAUGE, HEAD, campaign_of
from tests.laboratory.few_effects import few_effects
from tests.laboratory.small_campaign import write_small_campaign

SCHEMAS = Path(__file__).parents[2] / "schemas"
TABLES = {
    "states": "states",
    "recordings/only/log": "recording",
    "fit": "fit",
    "unseen": "unseen",
    "evidence": "evidence",
    "refits": "refits",
}


@pytest.mark.parametrize("name", sorted(schema_texts()))
def test_schemas_are_those_of_the_code(name: str) -> None:
    text = schema_texts()[name]
    jsonschema.Draft202012Validator.check_schema(json.loads(text))
    # renewed by: python -m stiffcal.schemas.tables schemas/
    assert (SCHEMAS / name).read_text(encoding="utf-8") == text


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """The store of a campaign in which something is missing, after a diagnosis."""
    from stiffcal.commands.validate import validate_campaign

    folder = write_small_campaign(tmp_path_factory.mktemp("tables") / "small", poses=3, hidden=COUPLED)
    validate_campaign(folder)
    with few_effects():
        assert diagnose_campaign(folder).evidence
    return Store(folder / "store", display_name="store")


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """The store of a campaign that logs over time."""
    folder = campaign_of(tmp_path_factory.mktemp("logs") / "small", HEAD, GAUGE, '[[runs]]\nid = "only"\n')
    ingest_campaign(folder)
    return Store(folder / "store", display_name="store")


def rows_of(table: pa.Table) -> list[dict[str, Any]]:
    """Return a table's rows as JSON has them: null for NaN."""
    rows: list[dict[str, Any]] = table.to_pylist()
    return [
        {name: None if isinstance(value, float) and np.isnan(value) else value for name, value in row.items()}
        for row in rows
    ]


def described(name: str, column: str) -> dict[str, Any]:
    """Return what a schema says of a column: exactly one entry of it."""
    schema = table_schema(name)
    found = [entry for known, entry in schema["properties"].items() if known == column]
    found += [entry for pattern, entry in schema["patternProperties"].items() if re.search(pattern, column)]
    (one,) = found
    return dict(one)


def test_there_is_no_table_without_a_schema(store: Store, logged: Store) -> None:
    kept = {name for name in store.tables if name.startswith(("fit-", "heldout-"))}
    # "read/…" is what stiffcal itself reads again, and nobody else
    assert {name for name in (*store.tables, *logged.tables) if not name.startswith("read/")} - kept == set(TABLES)
    # of every fit of the history its tables stay, by the fit's key
    assert {name.partition("-")[0] for name in kept} == {"fit", "heldout"}
    for name in kept:
        of_last_fit = "fit" if name.startswith("fit-") else "unseen"
        assert store.read_table(name).equals(store.read_table(of_last_fit))


@pytest.mark.parametrize("table", TABLES)
def test_tables_of_a_store_hold_to_their_schema(table: str, store: Store, logged: Store) -> None:
    found = (store if table in store.tables else logged).read_table(table)
    assert found.num_rows
    validator = jsonschema.Draft202012Validator(table_schema(TABLES[table]))
    for row in rows_of(found):
        validator.validate(row)
    for field in found.schema:
        reported = described(TABLES[table], field.name)
        assert reported["parquet"] == str(field.type)
        # a unit in a column's name is the one that the schema tells
        unit = re.search(r"_(rad|Nm|N|m|s|K|kg|A)(_(measured|predicted|residual))?$", field.name)
        if unit is not None:
            assert reported["unit"].replace("·", "") == unit[1]
    # and the schema is no empty promise
    row = rows_of(found)[0]
    for column in table_schema(TABLES[table])["required"]:
        assert not validator.is_valid({name: value for name, value in row.items() if name != column})
    assert not validator.is_valid(row | {"what": 1.0})


def test_what_may_not_be_missing_is_refused(store: Store) -> None:
    validator = jsonschema.Draft202012Validator(table_schema("states"))
    row = rows_of(store.read_table("states"))[0]
    assert validator.is_valid(row | {"target_rx_rad": None})
    assert not validator.is_valid(row | {"A1_rad": None})
    assert np.isfinite(values_of(store.read_table("states").column("A1_rad"))).all()
