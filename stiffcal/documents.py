"""Results as JSON documents: written out, and read back; `stiffcal.schemas.json_schema` describes them by a schema.

A result is a frozen dataclass that the package which computes it returns. Its fields are the keys of its document, in
their order; nested results are objects, arrays are lists, NaN is null. Marks in a field's annotation say more:
`OrAbsent` (no key where None), `KeyIf` (a key where a property of the result is true), `NOT_IN_DOCUMENT`,
`NOT_PROMISED` (in no schema), `HAS_OWN_SCHEMA` (an answer inside another one), and `ManyKeys` (results by name).

Why not pydantic's own dumping: keys that are absent where nothing is known need a newer pydantic than is required
here, and a command that only writes would wait for an adapter to be built. Schemas and reading are pydantic's.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from functools import cache
from pathlib import PurePath
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, TypeVar, Union, cast, get_args, get_type_hints

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, TypeAdapter
    from pydantic_core import CoreSchema

Document: TypeAlias = dict[str, Any]
"""A JSON object: where it enters or leaves the program, never between rooms."""

Result = TypeVar("Result")
Known = TypeVar("Known")


@dataclass(frozen=True, slots=True)
class KeyIf:
    """The mark of a field whose key stands in the document only where a property of the result is true."""

    condition: str
    """The property's name; "" where the key stands unless the field is None."""
    null: bool = True
    """Whether the key may hold null where it stands."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Take null out of what a document may hold, where it may not."""
        if self.null:
            return handler(source)
        return handler(Union[tuple(kind for kind in get_args(source) if kind is not NoneType)])  # noqa: UP007


@dataclass(frozen=True, slots=True)
class NotInDocument:
    """The mark of a field that is for Python alone; it needs a default where the result is read back from documents."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Accept no value for it."""
        from pydantic_core.core_schema import none_schema

        return none_schema()


@dataclass(frozen=True, slots=True)
class ManyKeys:
    """The mark of results by name, each of which is a key of the document where the field stands."""

    types: Callable[[], Mapping[str, Any]]
    """Returns the types of those that there may be, by name; asked whenever a document is read or described."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read every result by its own type."""
        from pydantic_core.core_schema import typed_dict_field, typed_dict_schema

        return typed_dict_schema(
            {
                name: typed_dict_field(handler.generate_schema(kind), required=False)
                for name, kind in self.types().items()
            }
        )


@dataclass(frozen=True, slots=True)
class NullIsNan:
    """The mark of a number whose null is NaN in Python, because None already means that the key is absent."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read null as NaN."""
        from pydantic_core.core_schema import no_info_after_validator_function

        return no_info_after_validator_function(lambda value: math.nan if value is None else value, handler(source))


@dataclass(frozen=True, slots=True)
class NotPromised:
    """The mark of a field that is written, but stands in no schema: other programs may not rely on it."""


@dataclass(frozen=True, slots=True)
class HasOwnSchema:
    """The mark of an answer inside another one: what it holds, the schema of its own kind describes."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Accept any object."""
        return handler(dict[str, Any])


@dataclass(frozen=True, slots=True)
class ListsOf:
    """The mark of an array that is nested lists of numbers in the document."""

    dimensions: int
    gaps: bool = False
    """Whether a number may be null, which is NaN in the array."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read lists of numbers as an array."""
        from pydantic_core.core_schema import no_info_after_validator_function

        kind: Any = float | None if self.gaps else float
        for _ in range(self.dimensions):
            kind = list[kind]
        return no_info_after_validator_function(_array, handler(kind))


def _array(rows: Any) -> Any:
    import numpy as np

    return np.array(rows, dtype=np.float64)


NOT_IN_DOCUMENT = NotInDocument()
NOT_PROMISED = NotPromised()
HAS_OWN_SCHEMA = HasOwnSchema()
OrAbsent: TypeAlias = Annotated[Known | None, KeyIf("", null=False)]
Origin: TypeAlias = Literal["own", "trusted place", "foreign"]
"""From whom results come: the user's own runs, a place that the user trusts, or anybody else."""
Number: TypeAlias = float | None
"""A number, null where it is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandResult:
    """What every command answers."""

    schema: str
    """The document's kind and version, "stiffcal/NAME/1"."""
    warnings: list[str]
    """What a reader of the result must know, a line each."""

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read the keys of results by name into their field."""
        from pydantic_core.core_schema import no_info_before_validator_function

        schema, kind = handler(source), cast("Any", cls)
        many_keys: Mapping[str, ManyKeys] = fields_of_many_keys(kind)
        if not many_keys:
            return schema
        names = {field: tuple(mark.types()) for field, mark in many_keys.items()}
        return no_info_before_validator_function(lambda document: _gathered(document, names), schema)

    def to_document(self) -> Document:
        """Return the document that the command prints with ``--json``."""
        return document_of(self)


def _gathered(document: Any, names: Mapping[str, tuple[str, ...]]) -> Any:
    """Return what was read with the keys of results by name in one object, by the name of their field."""
    if not isinstance(document, Mapping):
        return document
    every = {name for members in names.values() for name in members}
    gathered = {key: value for key, value in document.items() if key not in every}
    return gathered | {
        field: {name: document[name] for name in members if name in document} for field, members in names.items()
    }


def document_of(result: Any) -> Document:
    """Return a result as a JSON document.

    Parameters
    ----------
    result : a dataclass.

    Returns
    -------
    dict
        Keys in the order of the fields; finite numbers, texts, true, false, null, lists and objects alone.

    Raises
    ------
    TypeError : the result holds a value that JSON has no form for.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Point:
    ...     position: tuple[float, float]
    ...     stiffness: Number
    ...     picture: OrAbsent[str] = None
    >>> document_of(Point((0.0, 1.0), float("nan")))
    {'position': [0.0, 1.0], 'stiffness': None}
    """
    document: Document = {}
    kind: Any = type(result)
    many_keys = fields_of_many_keys(kind)
    for name, mark in written_fields(kind):
        value = getattr(result, name)
        if mark is not None and not (getattr(result, mark.condition) if mark.condition else value is not None):
            continue
        if name in many_keys:
            document |= json_value(value)
        elif type(value) is float:  # as most values of long answers are
            document[name] = value if math.isfinite(value) else None
        else:
            document[name] = value if type(value) in _PLAIN else json_value(value)
    return document


_PLAIN = (str, int, bool, NoneType)


def json_value(value: Any) -> Any:
    """Return a value as JSON has it; a number that is not finite is null.

    Raises
    ------
    TypeError : JSON has no form for it.
    """
    kind = type(value)
    if kind is float:
        return value if math.isfinite(value) else None
    if kind in _PLAIN:
        return value
    if kind is list:  # as most of long answers are
        return [json_value(item) for item in value]
    if kind is dict:
        return {str(key): json_value(item) for key, item in value.items()}
    np: Any = sys.modules.get("numpy")  # where nobody has imported it, there is no array
    if np is not None and isinstance(value, np.ndarray):
        finite = value.dtype.kind in "biuUS" or bool(np.isfinite(value).all())
        return value.tolist() if finite else json_value(value.tolist())
    if isinstance(value, list | tuple):  # of a type of its own too
        return [json_value(item) for item in value]
    if isinstance(value, Mapping):
        return {str(key): json_value(item) for key, item in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return document_of(value)
    if isinstance(value, Enum):
        return value.value
    if np is not None and isinstance(value, np.generic):
        return json_value(value.item())
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, float | int | str):  # of a type of its own
        return json_value(float(value)) if isinstance(value, float) else value
    raise TypeError(f"JSON has no form for {kind.__name__}")


@cache
def written_fields(kind: Any) -> tuple[tuple[str, KeyIf | None], ...]:
    """Return the fields that stand in the document, with what the presence of the key depends on."""
    written: list[tuple[str, KeyIf | None]] = []
    for name, marks in marks_of(kind).items():
        if NOT_IN_DOCUMENT not in marks:
            written.append((name, next((mark for mark in marks if isinstance(mark, KeyIf)), None)))
    return tuple(written)


def results_by_name(kind: Any) -> dict[str, Any]:
    """Return the types of the results that are keys of a document next to its fields, by name; none of other types."""
    if not (isinstance(kind, type) and is_dataclass(kind)):
        return {}
    return {name: one for mark in fields_of_many_keys(kind).values() for name, one in mark.types().items()}


@cache
def fields_of_many_keys(kind: Any) -> Mapping[str, ManyKeys]:
    """Return the fields each of whose entries is a key of the document, with their marks."""
    return {name: mark for name, marks in marks_of(kind).items() for mark in marks if isinstance(mark, ManyKeys)}


@cache
def marks_of(kind: Any) -> dict[str, tuple[Any, ...]]:
    """Return the fields of a result type by name, with the marks in their annotations."""
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: getattr(hints[field.name], "__metadata__", ()) for field in fields(kind)}


def _adapter(kind: Any) -> TypeAdapter[Any]:
    hashable: Any = kind
    marks = fields_of_many_keys(hashable).values() if is_dataclass(kind) else ()
    return _adapter_of(hashable, tuple(item for mark in marks for item in mark.types().items()))


@cache
def _adapter_of(kind: Any, by_name: tuple[tuple[str, Any], ...]) -> TypeAdapter[Any]:
    """Return the adapter of a type.

    Parameters
    ----------
    by_name : the types of results that it may hold by name: where they are others, so is the adapter.
    """
    from pydantic import TypeAdapter

    return TypeAdapter(kind)


def result_of(kind: type[Result], text: str | bytes) -> Result:
    """Return a result that was written as a document.

    Parameters
    ----------
    kind : of the result.
    text : the document's JSON; it may hold more keys than the result has fields.

    Raises
    ------
    pydantic.ValidationError : a key is missing, or holds something else than the field's type.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Point:
    ...     position: list[float]
    >>> result_of(Point, '{"position": [0, 1.5], "by": "hand"}').position
    [0.0, 1.5]
    """
    hashable: Any = kind
    result: Result = _adapter(hashable).validate_json(text, strict=True)
    return result


def result_from_values(kind: type[Result], document: Document) -> Result:
    r"""Return a result from its document as one process of stiffcal hands it to another.

    Unlike `result_of` it takes texts that are no Unicode: names of files may be any bytes.

    Parameters
    ----------
    kind : of the result.
    document : as `document_of` returned it.

    Raises
    ------
    pydantic.ValidationError : a key is missing, or holds something else than the field's type.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Named:
    ...     file: str
    >>> result_from_values(Named, document_of(Named("M\udcfcller"))).file == "M\udcfcller"
    True
    """
    hashable: Any = kind
    result: Result = _adapter(hashable).validate_python(document)
    return result


def section_of(kind: type[Result], document: Document, name: str) -> Result | None:
    """Return the part of a document that is a result of its own.

    Parameters
    ----------
    kind : of the part.
    document : the whole.
    name : the key of the part.

    Returns
    -------
    Result | None
        None where the document does not hold it.

    Raises
    ------
    pydantic.ValidationError : it holds something else than the kind's fields.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Point:
    ...     position: list[float]
    >>> section_of(Point, {"end": {"position": [0, 1.5]}}, "end").position, section_of(Point, {}, "end")
    ([0.0, 1.5], None)
    """
    return result_of(kind, json.dumps(document[name])) if document.get(name) is not None else None
