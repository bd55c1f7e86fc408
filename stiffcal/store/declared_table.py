"""What a stored table is declared to hold: a pyarrow schema with unit and meaning of each column in its metadata.

The writer casts a table to its declaration, the reader compares what it has read with it, the JSON Schemas and the page
on the store's tables are made from it. In a declared name ``<k>`` is a number from 1, any other ``<…>`` what a campaign
calls a joint, a target, a rod. The files carry unit and meaning too: ``schema.field("Fx_N").metadata``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, TypeAlias

import pyarrow as pa

if TYPE_CHECKING:
    from stiffcal.measurements.set_aside import SetAsideCode

NUMBER, COUNT, TRUTH, WORD = pa.float64(), pa.int64(), pa.bool_(), pa.string()
UNIT, MEANING = b"unit", b"description"
"""Keys of a column's metadata; the table's own has the second one."""


@dataclass(frozen=True)
class DeclaredTable:
    """A table of the store."""

    name: str
    """In the store; of tables that there are many of, what they are called in words."""
    meaning: str
    """What a row is, one sentence."""
    schema: pa.Schema
    """The columns, in the order in which they are described. ``nullable``: a number may be missing, NaN in the file."""
    optional: frozenset[str] = frozenset()
    """Columns without <…> that not every such table has; those with <…> are always so."""
    beginnings: tuple[str, ...] = ()
    """How the names of further tables of this form begin: one for each log, or for each fit of the history."""

    def is_called(self, name: str) -> bool:
        """Return whether a table of the store is of this form."""
        return name == self.name or name.startswith(self.beginnings)

    @cached_property
    def required(self) -> tuple[str, ...]:
        """The columns that each such table has."""
        return tuple(name for name in self.schema.names if "<" not in name and name not in self.optional)

    @cached_property
    def _patterns(self) -> list[tuple[re.Pattern[str], pa.Field]]:
        """The columns with <…> in their names, those with most letters of their own first."""
        free = [field for field in self.schema if "<" in field.name]
        free.sort(key=lambda field: -len(re.sub("<[^>]+>", "", field.name)))
        # a header of a spreadsheet, and so a joint's name, may hold the end of a line
        return [(re.compile(pattern_of(field.name), re.DOTALL), field) for field in free]

    @cached_property
    def _found(self) -> dict[str, pa.Field | None]:
        """What `field` has found: ten thousand logs have the same columns each."""
        return {}

    def field(self, column: str) -> pa.Field | None:
        """Return the declaration of a column, under its own name; None where there is none."""
        if column not in self._found:
            number = self.schema.get_field_index(column)
            fitting = (field.with_name(column) for form, field in self._patterns if form.fullmatch(column))
            self._found[column] = self.schema.field(number) if number >= 0 else next(fitting, None)
        return self._found[column]

    def schema_of(self, columns: Iterable[str], metadata: Mapping[bytes, bytes] | None = None) -> pa.Schema:
        """Return the schema of a table with these columns.

        Raises
        ------
        ValueError : one of them is not declared, or one that each such table has is missing.
        """
        names = list(columns)
        fields = [self.field(name) for name in names]
        unknown = [name for name, field in zip(names, fields, strict=True) if field is None]
        missing = [name for name in self.required if name not in names]
        if unknown or missing:
            raise ValueError(f"table {self.name}: not declared: {unknown}; missing: {missing}")
        return pa.schema(fields, {**(metadata or {}), MEANING: self.meaning.encode()})

    def cast(self, table: pa.Table) -> pa.Table:
        """Return the table as it is declared; its own metadata stay.

        Raises
        ------
        ValueError : as `schema_of`; pa.ArrowInvalid, a ValueError too, where values are not of the declared type.
        """
        schema = self.schema_of(table.column_names, table.schema.metadata)
        columns = [
            column if column.type == field.type else column.cast(field.type)
            for column, field in zip(table.columns, schema, strict=True)
        ]
        return pa.Table.from_arrays(columns, schema=schema)

    def difference(self, found: pa.Schema, columns: Sequence[str] | None = None) -> str:
        """Return how a table that was read differs from what is declared, "" where it does not.

        Parameters
        ----------
        found : its schema. columns : that were asked for; None: all.
        """
        for name in self.required if columns is None else columns:
            if name not in found.names:
                return f"it has no column {name}"
        for column in found:
            declared = self.field(column.name)
            if declared is not None and column.type != declared.type:
                return f"column {column.name} holds {column.type}, not {declared.type}"
        return ""


Declared: TypeAlias = Callable[[str], DeclaredTable | None]
"""Finds the declaration of a table by its name; None where there is none."""


def column(name: str, kind: pa.DataType, meaning: str, unit: str = "", missing: bool = False) -> pa.Field:
    """Return the declaration of a column.

    Parameters
    ----------
    name : with <…> for what a campaign calls its parts. kind : NUMBER, COUNT, TRUTH or WORD. meaning : in words.
    unit : SI; "" for words, counts, truth values and numbers without one. missing : whether a number may be missing.
    """
    return pa.field(name, kind, missing, {UNIT: unit.encode(), MEANING: meaning.encode()})


def columns(names: str, axes: str, meaning: str, unit: str = "", missing: bool = False) -> list[pa.Field]:
    """Return the declarations of numbers along axes, ``{}`` in their names."""
    return [column(names.format(axis), NUMBER, meaning, unit, missing) for axis in axes]


def cause_column(subject: str, codes: Iterable[SetAsideCode]) -> pa.Field:
    """Return the declaration of the column that holds why something is not used.

    Parameters
    ----------
    subject : what a row is. codes : the causes that there are.
    """
    causes = ", ".join(filter(None, codes))
    return column("set_aside_code", WORD, f"the cause in one word, empty where the {subject} is used: {causes}")


@lru_cache(maxsize=1024)
def pattern_of(name: str) -> str:
    """Return the expression of a column's names; <k> is a number from 1, any other <…> a name.

    Examples
    --------
    >>> pattern_of("<target>_x_m"), pattern_of("temperature<k>")
    ('.+_x_m', 'temperature[1-9][0-9]*')
    """
    return re.sub(r"<[^>]+>", ".+", re.sub(r"<k>", "[1-9][0-9]*", name))
