"""Tables of absolute places of the bundled campaigns, changed by a mistake."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffcal.errors import Fault, InputError
from stiffcal.ingest.reading.reducing import ReducedCampaign

CAMPAIGNS = Path(__file__).parents[2] / "campaigns" / "absolute"
Table = dict[str, list[float]]
PLACE = ("X1", "Y1", "Z1")
Reduce = Callable[[str, Callable[[Table], None]], ReducedCampaign]


def fault_of(reduced: Reduce, name: str, change: Callable[[Table], None]) -> Fault:
    """Return the one fault."""
    with pytest.raises(InputError) as refused:
        reduced(name, change)
    (fault,) = refused.value.faults
    assert "\n" not in fault.reason + fault.mend
    return fault


def scaled(column: str, factor: float, rows: slice = slice(None)) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        values = np.array(table[column])
        values[rows] *= factor
        table[column] = values.tolist()

    return change


def all_of(*changes: Callable[[Table], None]) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        for each in changes:
            each(table)

    return change


def exchanged(table: Table, rows: slice) -> None:
    for axis in "XYZ":
        first, second = np.array(table[f"{axis}1"]), np.array(table[f"{axis}2"])
        first[rows], second[rows] = second[rows].copy(), first[rows].copy()
        table[f"{axis}1"], table[f"{axis}2"] = first.tolist(), second.tolist()


def columns(first: str, second: str, rows: slice = slice(None)) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        one, other = np.array(table[first]), np.array(table[second])
        one[rows], other[rows] = other[rows].copy(), one[rows].copy()
        table[first], table[second] = one.tolist(), other.tolist()

    return change
