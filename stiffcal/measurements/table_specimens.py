"""A stored table as its schema describes it: a specimen of one row, and what its columns mean."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import pyarrow as pa

from stiffcal.measurements.set_aside import SetAsideCode


@dataclass(frozen=True)
class ColumnDescription:
    """What a column holds."""

    text: str
    """The column's meaning, in words."""
    unit: str = ""
    """SI unit; "" for words, counts, truth values and numbers without one."""
    missing: bool = False
    """True where a number may be missing."""


@dataclass(frozen=True)
class TableSpecimen:
    """A table with one row, as the code writes it, of a robot with a joint ``<joint>`` and a target ``<target>``."""

    text: str
    """What a row of the table is."""
    table: pa.Table
    """With one row."""
    columns: Mapping[str, ColumnDescription]
    """What each column means, neither more nor fewer than the table has."""


def cause_column(subject: str, codes: Iterable[SetAsideCode]) -> ColumnDescription:
    """Return the description of a column that holds why something is not used.

    Parameters
    ----------
    subject : what a row is. codes : the causes that there are.
    """
    return ColumnDescription(
        f"the cause in one word, empty where the {subject} is used: {', '.join(filter(None, codes))}"
    )
