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

from stiffcal.campaign.manifest.source import Source
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.errors import InputError
from stiffcal.ingest.reading.recording_tables import recording_columns
from stiffcal.kinds.declared_tables import campaign_store, declared_table, declared_tables
from stiffcal.measurements.columns import values_of
from stiffcal.reduction.logs.log_rows import LogRows
from stiffcal.schemas.tables import schema_texts, table_schema
from stiffcal.store import Store
from stiffcal.store.declared_table import MEANING, UNIT, DeclaredTable
from stiffcal.store.tables import RECORDING, STATES
from tests.commands.test_improve import COUPLED
from tests.ingest.test_logged_runs import GAUGE, HEAD, campaign_of
from tests.laboratory.few_effects import few_effects
from tests.laboratory.small_campaign import write_small_campaign

SCHEMAS = Path(__file__).parents[2] / "schemas"
TABLES = (
    "states",
    "recordings/only/log",
    "fit",
    "unseen",
    "evidence",
    "refits",
    "read/states",
    "read/runs",
    "read/sources",
)


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
    return campaign_store(folder / "store", "store")


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """The store of a campaign that logs over time."""
    folder = campaign_of(tmp_path_factory.mktemp("logs") / "small", HEAD, GAUGE, '[[runs]]\nid = "only"\n')
    ingest_campaign(folder)
    return campaign_store(folder / "store", "store")


def rows_of(table: pa.Table) -> list[dict[str, Any]]:
    """Return a table's rows as JSON has them: null for NaN."""
    rows: list[dict[str, Any]] = table.to_pylist()
    return [
        {name: None if isinstance(value, float) and np.isnan(value) else value for name, value in row.items()}
        for row in rows
    ]


def declaration(name: str) -> DeclaredTable:
    """Return what a table is declared to hold."""
    declared = declared_table(name)
    assert declared is not None
    return declared


def described(name: str, column: str) -> dict[str, Any]:
    """Return what a schema says of a column: exactly one entry of it."""
    schema = table_schema(declaration(name))
    found = [entry for known, entry in schema["properties"].items() if known == column]
    found += [entry for pattern, entry in schema["patternProperties"].items() if re.search(pattern, column)]
    (one,) = found
    return dict(one)


def test_there_is_no_table_without_a_declaration(store: Store, logged: Store) -> None:
    kept = {name for name in store.tables if name.startswith(("fit-", "heldout-"))}
    # of every fit of the history its tables stay, by the fit's key
    assert {name.partition("-")[0] for name in kept} == {"fit", "heldout"}
    for name in kept:
        of_last_fit = "fit" if name.startswith("fit-") else "unseen"
        assert store.read_table(name).equals(store.read_table(of_last_fit))
    assert {*store.tables, *logged.tables} - kept == set(TABLES)


@pytest.mark.parametrize("name", [table.name for table in declared_tables()])
def test_each_column_has_a_meaning_and_the_unit_that_its_name_states(name: str) -> None:
    declared = next(table for table in declared_tables() if table.name == name)
    for field in declared.schema:
        assert field.metadata[MEANING]
        unit = re.search(r"_(rad|radps2?|Nm|N|m|s|ns|K|kg|A)(_(measured|predicted|residual))?$", field.name)
        if unit is not None and unit[1] != "ns":
            written = field.metadata[UNIT].decode()
            assert written.replace("·", "").replace("/s²", "ps2").replace("/s", "ps") == unit[1], field.name
    assert {*declared.optional} <= {*declared.schema.names}


@pytest.mark.parametrize("table", TABLES)
def test_tables_of_a_store_hold_to_their_schema(table: str, store: Store, logged: Store) -> None:
    stored = [one.read_table(table) for one in (store, logged) if table in one.tables]
    found = next(one for one in stored if one.num_rows)
    schema = table_schema(declaration(table))
    validator = jsonschema.Draft202012Validator(schema)
    for row in rows_of(found):
        validator.validate(row)
    for field in found.schema:
        reported = described(table, field.name)
        assert reported["parquet"] == str(field.type)
        # the file itself carries what is declared
        assert reported["description"] == field.metadata[MEANING].decode()
        assert reported.get("unit", "") == field.metadata[UNIT].decode()
    # and the schema is no empty promise
    row = rows_of(found)[0]
    for column in schema["required"]:
        assert not validator.is_valid({name: value for name, value in row.items() if name != column})
    assert not validator.is_valid(row | {"what": 1.0})


def test_what_may_not_be_missing_is_refused(store: Store) -> None:
    validator = jsonschema.Draft202012Validator(table_schema(STATES))
    row = rows_of(store.read_table("states"))[0]
    assert validator.is_valid(row | {"target_rx_rad": None})
    assert not validator.is_valid(row | {"A1_rad": None})
    assert np.isfinite(values_of(store.read_table("states").column("A1_rad"))).all()


FIT = {"state": np.arange(2), "run": ["a", "b"], "row": np.arange(2), "tip_dx_m_residual": np.zeros(2)}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"tip_dx_m_residual": ["x", "y"]}, "column tip_dx_m_residual holds string, not double"),
        ({"row": None}, "it has no column row"),
    ],
)
def test_a_table_that_differs_is_one_line_when_it_is_read(tmp_path: Path, change: dict[str, Any], reason: str) -> None:
    """An earlier version, or a stranger, has written it."""
    columns = {name: values for name, values in (FIT | change).items() if values is not None}
    Store(tmp_path / "store").commit({"fit": columns})
    with pytest.raises(InputError) as refused:
        campaign_store(tmp_path / "store", "store").read_table("fit")
    (fault,) = refused.value.faults
    assert (fault.code.value, fault.file, fault.place) == ("store-damaged", "store", "fit")
    assert reason in fault.reason


def test_a_writer_holds_to_the_declaration(tmp_path: Path) -> None:
    store = campaign_store(tmp_path / "store", "store")
    nothing: dict[str, list[str]] = {name: [] for name in FIT}  # empty columns have no type of their own
    store.commit({"fit": nothing})
    assert [str(kind) for kind in store.read_table("fit").schema.types] == ["int64", "string", "int64", "double"]
    for wrong in (FIT | {"colour": np.zeros(2)}, {"state": np.arange(2)}):
        with pytest.raises(ValueError, match="table fit"):
            store.commit({"fit": wrong})


@pytest.mark.parametrize(
    ("signal", "width", "names"),
    [
        ("sigma.position.tip", 1, ["tip_sigma_m"]),
        ("sigma.rotation.tip", 3, ["tip_rx_sigma_rad", "tip_ry_sigma_rad", "tip_rz_sigma_rad"]),
        ("marker.tip.m1", 3, ["tip.m1_x_m", "tip.m1_y_m", "tip.m1_z_m"]),
        ("joints.approach", 1, ["joints_approach1_sign"]),
        ("temperature", 1, ["temperature1_K"]),
        ("joints", 1, ["Axis 1\n[deg]_rad"]),
    ],
)
def test_each_signal_of_a_log_is_declared(signal: str, width: int, names: list[str]) -> None:
    source = Source.model_validate({"joints": {"position": ["Axis 1\n[deg]"]}})
    rows = LogRows(np.zeros(1, dtype=np.int64), np.zeros(1), [], {signal: np.zeros((width, 1))})
    assert recording_columns(source, rows) == ["time_s", *names]
    assert RECORDING.schema_of(["time_s", *names]).names == ["time_s", *names]
