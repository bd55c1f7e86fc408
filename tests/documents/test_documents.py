"""Results as JSON documents: what is written, what the schema asks for, what is read back."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

import jsonschema
import numpy as np
import pytest
from pydantic import ValidationError

from stiffcal.document_arrays import Matrix, Vector, VectorWithGaps
from stiffcal.documents import (
    NOT_IN_DOCUMENT,
    NOT_PROMISED,
    CommandResult,
    KeyIf,
    Number,
    OrAbsent,
    document_of,
    result_of,
)
from stiffcal.escapes.terminal import escaped_document
from stiffcal.measurements.rms import Rms
from stiffcal.schemas.json_schema import schema_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """A spring with its stiffness where it is a compliance."""

    name: str
    place: Vector
    covariance: Matrix | None
    unit: str
    stiffness: Annotated[Number, KeyIf("is_compliance")] = None

    @property
    def is_compliance(self) -> bool:
        return self.unit == "m/N"


@dataclass(frozen=True, slots=True, kw_only=True)
class Springs(CommandResult):
    """Springs, and a picture of them."""

    schema: Literal["stiffcal/springs/1"] = "stiffcal/springs/1"
    springs: list[Spring]
    file: OrAbsent[str] = None
    arrays: Annotated[dict[str, Any] | None, NOT_IN_DOCUMENT] = None


def spring(**changes: Any) -> Spring:
    fields: dict[str, Any] = {"name": "A1", "place": np.array([0.0, 1.5]), "covariance": None, "unit": "rad"}
    return Spring(**(fields | changes))


def springs(*held: Spring, **changes: Any) -> Springs:
    fields: dict[str, Any] = {"warnings": ["soft"], "springs": list(held)}
    return Springs(**(fields | changes))


def test_keys_are_the_fields_in_their_order() -> None:
    document = document_of(springs(spring()))
    assert list(document) == ["schema", "warnings", "springs"]
    assert document["springs"] == [{"name": "A1", "place": [0.0, 1.5], "covariance": None, "unit": "rad"}]


def test_a_key_that_may_be_absent_stands_where_its_field_is_known() -> None:
    assert "file" not in document_of(springs())
    assert document_of(springs(file="map.svg"))["file"] == "map.svg"


def test_a_conditional_key_is_null_where_the_condition_holds_and_nothing_is_known() -> None:
    assert "stiffness" not in document_of(spring(stiffness=1.0))
    assert document_of(spring(unit="m/N"))["stiffness"] is None


def test_what_is_for_python_alone_is_not_written() -> None:
    assert "arrays" not in document_of(springs(arrays={"values": np.zeros(3)}))


@pytest.mark.parametrize(
    ("value", "written"),
    [
        (float("nan"), None),
        (float("inf"), None),
        (np.float64(1.5), 1.5),
        (np.array([1.0, np.nan]), [1.0, None]),
        (np.array([[1, 2]]), [[1, 2]]),
        (np.bool_(True), True),
        (PurePosixPath("a/b"), "a/b"),
        ((1, (2.0, "x")), [1, [2.0, "x"]]),
        ({"a": np.int64(1)}, {"a": 1}),
    ],
)
def test_values_as_json_has_them(value: Any, written: Any) -> None:
    @dataclass
    class Holder:
        value: Any

    document = document_of(Holder(value))
    assert json.loads(json.dumps(document, allow_nan=False)) == {"value": written}


def test_a_value_without_a_form_in_json_is_refused() -> None:
    with pytest.raises(TypeError, match="no form for set"):
        document_of(spring(name={1, 2}))


def test_a_document_gives_its_result_back() -> None:
    first = springs(spring(covariance=np.eye(2)), spring(unit="m/N", stiffness=2.0), file="a.svg")
    read = result_of(Springs, json.dumps(document_of(first)))
    assert document_of(read) == document_of(first)
    assert isinstance(read.springs[0].covariance, np.ndarray)


@pytest.mark.parametrize(
    "change",
    [
        {"file": None},
        {"arrays": {}},
        {"springs": [{"name": "A1"}]},
        {"warnings": "soft"},
        {"schema": "stiffcal/springs/2"},
    ],
)
def test_a_document_of_another_shape_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        result_of(Springs, json.dumps(document_of(springs()) | change))


def test_the_schema_requires_what_always_stands() -> None:
    schema = schema_of(Springs)
    assert schema["required"] == ["schema", "warnings", "springs"]
    assert "arrays" not in schema["properties"]
    held = jsonschema.Draft202012Validator(schema)
    held.validate(document_of(springs(spring(), spring(unit="m/N"), file="x")))
    assert not held.is_valid(document_of(springs()) | {"file": None})


def test_texts_of_a_result_reach_no_terminal_unescaped() -> None:
    shown = escaped_document(springs(spring(name="A1\x1b[2J"), file=str(Path("a\x07.svg"))))
    assert (shown.springs[0].name, shown.file) == ("A1\\x1b[2J", "a\\x07.svg")
    assert isinstance(shown, Springs)


def test_a_measure_that_applies_and_is_not_known_is_null_and_nan() -> None:
    assert document_of(Rms(1.0, None)) == {"translation": 1.0, "rotation": None}
    written = document_of(Rms(1.0, None, torque=float("nan")))
    assert written == {"translation": 1.0, "rotation": None, "torque": None}
    read = result_of(Rms, json.dumps(written))
    assert read.length is None
    assert read.torque is not None
    assert np.isnan(read.torque)
    assert dict(read.items()) == written


def test_what_is_not_promised_is_written_and_stands_in_no_schema() -> None:
    @dataclass(frozen=True)
    class Fit:
        rms: float
        iterations: Annotated[int, NOT_PROMISED] = 0

    assert document_of(Fit(1.0, 3)) == {"rms": 1.0, "iterations": 3}
    assert list(schema_of(Fit)["properties"]) == ["rms"]


def test_a_gap_in_an_array_is_null_and_nan_where_gaps_may_be() -> None:
    @dataclass(frozen=True)
    class Frame:
        std: VectorWithGaps

    @dataclass(frozen=True)
    class Whole:
        std: Vector

    text = json.dumps(document_of(Frame(np.array([1e-3, np.nan]))))
    assert text == '{"std": [0.001, null]}'
    assert np.array_equal(result_of(Frame, text).std, [1e-3, np.nan], equal_nan=True)
    with pytest.raises(ValidationError):
        result_of(Whole, text)
