"""The rows of a log that the manifest's conditions keep, judged before they become signals."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.signals.row_filter import condition_text
from stiffcal.campaign.toml.toml_reading import LARGEST, SMALLEST
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import Batch
from stiffcal.reduction.logs.excluded_rows import RowExclusions

_CONDITIONS: dict[str, Callable[[Floats, float], NDArray[np.bool_]]] = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}


@dataclass(frozen=True)
class KeptRows:
    """The rows of a batch that meet the conditions of ``rows``, in the log's own units."""

    number: Integers
    """(n,) data rows, from 1."""
    numbers: Mapping[str, Floats]
    """Column to (n,)."""
    run: list[str]
    """The n names of the run column, or empty."""

    def chosen(self, keep: NDArray[np.bool_]) -> KeptRows:
        """Return the rows of a mask (n,)."""
        numbers = {name: values[keep] for name, values in self.numbers.items()}
        return KeptRows(self.number[keep], numbers, [self.run[k] for k in np.flatnonzero(keep)] if self.run else [])


def kept_rows(source: Source, batch: Batch) -> KeptRows:
    """Return the rows of a batch that meet the conditions of ``rows``."""
    n = len(batch)
    number = np.arange(batch.first_row, batch.first_row + n, dtype=np.int64)
    keep = np.ones(n, dtype=np.bool_)
    for condition in source.row_conditions:
        if condition.value == "" and condition.column in batch.numbers:  # whether there is a reading
            has_none = np.isnan(batch.numbers[condition.column])
            keep &= has_none if condition.operator == "==" else ~has_none
        elif isinstance(condition.value, str):
            same = np.array([word == condition.value for word in batch.texts[condition.column]], dtype=np.bool_)
            keep &= same if condition.operator == "==" else ~same
        else:
            keep &= _CONDITIONS[condition.operator](batch.numbers[condition.column], condition.value)
    words = batch.texts.get(source.run.column or "", []) if source.run else []
    rows = KeptRows(number, batch.numbers, words)
    return rows if keep.all() else rows.chosen(keep)


def columns_with_gaps(source: Source) -> frozenset[str]:
    """Return the columns in which a reading may be missing: points that were hidden, targets of tables of states.

    Of a joint's last motion too: of the first row it is seldom known.
    """
    columns: set[str] = set()
    for pose in source.body_poses().values():
        columns |= {column for marker in pose.markers.values() for column in marker.columns}
        if source.is_states:
            columns |= set(pose.column_names())
    if source.is_states and source.deflection is not None:
        columns |= set(source.deflection.column_names())
    if source.is_states and source.displacement is not None:
        columns |= set(source.displacement.column_names())
    if source.is_states:
        columns |= _sigma_columns(source)
    if source.joints is not None:
        columns |= set(source.joints.approach or ())
    return frozenset(columns)


def _sigma_columns(source: Source) -> set[str]:
    """Return the columns that hold uncertainties."""
    groups = [columns for signal in source.signals().values() for columns in signal.sigma_columns().values()]
    return {column for columns in groups for column in columns}


def unjudged_columns(source: Source, exclusions: RowExclusions) -> frozenset[str]:
    """Return the columns that a reader may not judge: rows that are left out are known only behind it."""
    if not exclusions.entries and not source.row_conditions:
        return frozenset()
    time = source.time.columns if source.time is not None else ()
    names = {name for signal in source.signals().values() for name in signal.column_names()}
    names |= _sigma_columns(source)
    return frozenset(names | {condition.column for condition in source.row_conditions} | set(time))


def first_missing(rows: KeptRows, optional: frozenset[str]) -> tuple[int, str] | None:
    """Return row and column of the first reading that is missing where it may not be."""
    worst: tuple[int, str] | None = None
    for column, values in rows.numbers.items():
        if column in optional or not np.isnan(values.sum()):
            continue
        bad = np.isnan(values)
        if bad.any() and (worst is None or rows.number[bad.argmax()] < worst[0]):
            worst = (int(rows.number[bad.argmax()]), column)
    return worst


def check_sizes(rows: KeptRows, files: Mapping[str, str]) -> None:
    """Raise where numbers are larger or all smaller than anything that is measured: their squares are no numbers."""
    for column, values in rows.numbers.items():
        sizes = np.where(np.isnan(values), 0.0, np.abs(values))
        largest = float(sizes.max(initial=0.0))
        if not (largest > LARGEST or 0.0 < largest < SMALLEST):  # a few tiny ones are what a filter leaves
            continue
        row = int(np.argmax(sizes))
        place = f"row {rows.number[row]}, column {column}"
        display_name = ", ".join(dict.fromkeys(files.values()))
        if not np.isfinite(largest):
            reason, mend = "the cell is no number", "correct it, or exclude its row with [[exclude]]"
        elif largest > LARGEST:
            # the end of a number of 32 or 64 bits stands where there is no reading, in many rows
            kept = condition_text(column, *(("<", LARGEST) if values[row] > 0.0 else (">", -LARGEST)))
            reason = f"{values[row]:g} is larger than any plausible value"
            mend = f"correct it, or leave such rows out: {toml_text.pair('rows', kept)} next to the columns' names"
        else:
            reason = f"{values[row]:g}, the column's largest number here, is smaller than any plausible value"
            mend = "correct its unit in the log, or write 0"
        raise InputError.at(FaultCode.NUMBER_INVALID, display_name, place, reason, mend)
