"""Rows of a table that repeat others with fewer digits: a table that was pasted twice, rounded the second time.

A rounded reading differs from the original by at most half a unit of its own last digit, in every cell, and has fewer
digits in most of them. Two readings of one load are printed with the same number of digits and end in zeros by chance
alone; how often that makes two rows look like a copy is known, and what chance explains is left alone.
Rows that agree in every digit are found by `stiffcal.reduction.repeated_rows`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats

Layout: TypeAlias = tuple[tuple[str, int], ...]
"""Signals of a row and their numbers of channels."""
_Place: TypeAlias = tuple[str, int]
"""A file and the number of a row in it."""
_Pair: TypeAlias = tuple[_Place, _Place]
"""A copy and its original."""
# What describes a state; what moved is among them. Orientations are computed, and have no digits of their own.
_MOVED = ("translation", "position", "marker", "lengths", "displacement")
_COMPARED = ("joints", "wrench", "mass", *_MOVED)
_MOST_DIGITS = 10  # behind the point: more than instruments print
_WHOLE = 1e-6  # a number of last digits is whole within this: rounding of floating-point numbers of ten digits
_NEIGHBOURS = 6  # rows next to a row that are compared with it
_ROWS_AT_ONCE = 1 << 14  # of which pairs are compared, so that memory stays flat
# The last digit is a zero in one of ten readings: as often a signal of one channel has fewer digits by chance.
_BY_CHANCE = 0.1
_CHANCE = 1e-3  # of so many pairs in one table
_HALF = 0.5 * (1.0 + 1e-6)
_COARSE = 0.95  # quantile of a column's last digits within which copies are looked for
MOST_NAMED = 10


@dataclass
class _Rows:
    """Rows of one layout."""

    values: list[Floats] = field(default_factory=list)
    """(n, c) SI, of each piece."""
    digits: list[Floats] = field(default_factory=list)
    """(n, c) size of the last digit of each, SI; 0 where that is not known."""
    places: list[_Place] = field(default_factory=list)
    """File and number of each row."""


@dataclass
class RoundedCopies:
    """Collects the rows of tables of states."""

    _of_layout: dict[Layout, _Rows] = field(default_factory=dict)

    def update(
        self,
        file: str,
        number: NDArray[np.int64],
        signals: Mapping[str, Floats],
        columns: Mapping[str, Sequence[str]],
        factors: Mapping[str, float],
    ) -> None:
        """Take in rows of a table.

        Parameters
        ----------
        file : as the user named it. number : (n,) the rows' numbers in it.
        signals : (c, n) SI. columns : of each signal in the file. factors : of a column's unit to SI.
        """
        taken = {
            name: values[: len(columns[name])]
            for name, values in sorted(signals.items())
            if name.partition(".")[0] in _COMPARED and not name.startswith("joints.") and columns.get(name)
        }
        if number.size == 0 or not any(name.partition(".")[0] in _MOVED for name in taken):
            return
        rows = self._of_layout.setdefault(tuple((name, len(values)) for name, values in taken.items()), _Rows())
        unit = np.array([factors.get(column, 1.0) for name in taken for column in columns[name]])
        values = np.concatenate(list(taken.values())).T
        rows.values.append(values)
        rows.digits.append(unit * last_digits(values / unit))
        rows.places += [(file, int(row)) for row in number]

    def warnings(self) -> list[str]:
        """Return a warning for the rows that repeat others with fewer digits; none where there are no such rows."""
        pairs: list[_Pair] = []
        for layout, rows in self._of_layout.items():
            found = _rounded_pairs(np.concatenate(rows.values), np.concatenate(rows.digits), layout)
            pairs += [(rows.places[copy], rows.places[original]) for copy, original in found]
        if not pairs:
            return []
        blocks = _blocks(sorted(pairs))
        named = "; ".join(_sentence(block) for block in blocks[:MOST_NAMED])
        more = f" and {len(blocks) - MOST_NAMED} more" if len(blocks) > MOST_NAMED else ""
        why = "readings that count twice make the noise appear smaller"
        return [f"rounded copies: {named}{more}, with fewer digits: {why}; exclude the copies with [[exclude]]"]


def last_digits(values: Floats) -> Floats:
    """Return the size of the last digit that is not zero of each number; 0 where there is none to be seen.

    Examples
    --------
    >>> last_digits(np.array([12.5, 0.125, 3.0, 0.0, 1.0 / 3.0])).tolist()
    [0.1, 0.001, 1.0, 0.0, 0.0]
    """
    size = np.zeros(values.shape)
    for digits in range(_MOST_DIGITS, -1, -1):
        scaled = values * 10.0**digits
        size[np.abs(scaled - np.round(scaled)) <= _WHOLE] = 10.0**-digits
    size[(values == 0.0) | ~np.isfinite(values)] = 0.0
    return size


def _rounded_pairs(values: Floats, digits: Floats, layout: Layout) -> list[tuple[int, int]]:
    """Return (copy, original) of the rows that repeat another one with fewer digits.

    Parameters
    ----------
    values, digits : (n, c), as of `_Rows`. layout : of the c columns.
    """
    rows = np.flatnonzero(np.isfinite(values).all(axis=1))
    if len(rows) < 2:
        return []
    tolerance = _HALF * _of_zeros_too(values, digits, layout)
    coarse = np.array([np.quantile(own[own > 0.0], _COARSE) if np.any(own > 0.0) else 1.0 for own in digits[rows].T])
    scaled = values[rows] / coarse
    near_others = _near_others(scaled)
    rows, scaled = rows[near_others], scaled[near_others]
    if not len(rows):
        return []
    from scipy.spatial import cKDTree  # takes longer to load than most tables take to be checked

    neighbours = min(_NEIGHBOURS, len(rows))
    _, near = cKDTree(scaled).query(scaled, k=neighbours, p=np.inf, distance_upper_bound=_HALF)
    near = np.asarray(near).reshape(len(rows), neighbours)
    alike: set[tuple[int, int]] = set()
    originals: dict[int, list[int]] = {}
    for start in range(0, len(rows), _ROWS_AT_ONCE):
        own, place = np.nonzero(near[start : start + _ROWS_AT_ONCE] < len(rows))
        copy, original = rows[start + own], rows[near[start + own, place]]
        agree = (copy != original) & np.all(np.abs(values[copy] - values[original]) <= tolerance[copy], axis=1)
        copy, original = copy[agree], original[agree]
        alike.update(zip(np.minimum(copy, original).tolist(), np.maximum(copy, original).tolist(), strict=True))
        coarser = _are_coarser(digits[copy], digits[original], layout)
        for one, other in zip(copy[coarser].tolist(), original[coarser].tolist(), strict=True):
            originals.setdefault(one, []).append(other)
    if not originals or _is_chance(len(originals), len(alike)):
        return []
    # several rows round to the same where nothing moved: the one as far away as the originals of other copies is meant
    distances = Counter(copy - original for copy, own in originals.items() for original in own)
    return [(copy, max(own, key=lambda row: distances[copy - row])) for copy, own in originals.items()]


def _near_others(scaled: Floats) -> Booleans:
    """Return (n,) True where a row may have another one within `_HALF` in every column; rows without one are False.

    Column by column, rows stay together that a chain of steps of at most `_HALF` connects: two rows that are near each
    other are never parted, and of measured values few others are left.
    """
    group = np.zeros(len(scaled), dtype=np.int64)
    for column in scaled.T:
        order = np.lexsort((column, group))
        parted = (np.diff(group[order]) != 0) | (np.diff(column[order]) > _HALF)
        group[order] = np.concatenate([[0], np.cumsum(parted)])
    return np.asarray(np.bincount(group)[group] > 1)


def _of_zeros_too(values: Floats, digits: Floats, layout: Layout) -> Floats:
    """Return the size of the last digit of each reading; of a zero that of the others of its signal."""
    filled = digits.copy()
    start = 0
    for _, count in layout:
        own = slice(start, start + count)
        largest = digits[:, own].max(axis=1, keepdims=True)
        filled[:, own] = np.where(values[:, own] == 0.0, largest, digits[:, own])
        start += count
    return filled


def _are_coarser(copy: Floats, original: Floats, layout: Layout) -> Booleans:
    """Return for each pair whether no reading of the original has fewer digits, and most of one signal have more.

    Parameters
    ----------
    copy, original : (n, c) sizes of the last digits; 0 where a reading is zero, or has all digits that a number holds.
    """
    compared = copy > 0.0
    finer = compared & (original < _HALF * copy)
    none_less = np.all(finer | ~compared | (original <= copy * (1.0 + _WHOLE)), axis=1)
    most_of_one = np.zeros(len(copy), dtype=np.bool_)
    start = 0
    for _, count in layout:
        own = slice(start, start + count)
        most_of_one |= 2 * finer[:, own].sum(axis=1) > compared[:, own].sum(axis=1)
        start += count
    return np.asarray(none_less & most_of_one)


def _is_chance(copies: int, alike: int) -> bool:
    """Return whether zeros at the end of readings make so many of the pairs that agree look like copies."""
    from scipy.special import bdtrc

    return bool(bdtrc(copies - 1, max(alike, copies), _BY_CHANCE) > _CHANCE * (1.0 + _WHOLE))


def _blocks(pairs: Sequence[_Pair]) -> list[list[_Pair]]:
    """Return copies together that stand as many rows behind their originals; some rows between may be none."""
    blocks: dict[tuple[str, str, int], list[_Pair]] = {}
    for pair in pairs:
        (file, row), (original_file, original_row) = pair
        blocks.setdefault((file, original_file, row - original_row), []).append(pair)
    return list(blocks.values())


def _sentence(block: Sequence[_Pair]) -> str:
    copies, originals = _rows_in_words([pair[0] for pair in block]), _rows_in_words([pair[1] for pair in block])
    gaps = block[-1][0][1] - block[0][0][1] + 1 > len(block)
    some = f" ({len(block)} of them)" if gaps else ""
    return f"{copies}{some} {'repeats' if len(block) == 1 else 'repeat'} {originals}"


def _rows_in_words(places: Sequence[_Place]) -> str:
    file, first = places[0]
    return f"{file} row {first}" if len(places) == 1 else f"{file} rows {first} to {places[-1][1]}"
