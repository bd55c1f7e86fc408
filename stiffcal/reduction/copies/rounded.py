"""Rows of a table that repeat others with fewer digits: a table that was pasted twice, rounded the second time.

A rounded reading differs from the original by at most half a unit of its own last digit, in every cell, and has fewer
digits in most of them. Two readings of one load are printed with the same number of digits and end in zeros by chance
alone; how often that makes two rows look like a copy is known, and what chance explains is left alone.
Rows that agree in every digit are found by `stiffcal.reduction.copies.repeated_rows`.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.reduction.copies.by_chance import MOST_PROBABLE, probability_of_as_many

Layout: TypeAlias = tuple[tuple[str, int], ...]
"""Signals of a row and their numbers of channels."""
_Place: TypeAlias = tuple[str, int]
"""A file and the number of a row in it."""
_Pair: TypeAlias = tuple[_Place, _Place]
"""A copy and its original."""
# What describes a state; what moved is among them. Orientations are computed, and have no digits of their own.
_MOVED = ("translation", "position", "marker", "lengths", "displacement")
_COMPARED = ("joints", "wrench", "mass", *_MOVED)
_MOST_DIGITS, _LEAST_DIGITS = 10, -3  # behind the point: more than instruments print, and thousands
_WHOLE = 1e-6  # a number of last digits is whole within this: rounding of floating-point numbers of ten digits
_NEIGHBOURS = 6  # rows next to a row that are compared with it
_ROWS_AT_ONCE = 1 << 14  # of which pairs are compared, so that memory stays flat
_LAST_DIGITS = range(1, 10)  # other than zero; readings end in each as often
_HALF = 0.5 * (1.0 + 1e-6)
_COARSE = 0.95  # quantile of a column's last digits within which copies are looked for
_FINE = 0.05  # quantile that is the last digit of most of its readings, where some are copies
MOST_NAMED = 10


@dataclass
class _Rows:
    """Rows of one layout."""

    values: list[Floats] = field(default_factory=list)
    """(n, c) SI, of each piece."""
    units: list[Floats] = field(default_factory=list)
    """(c,) of each piece: what one of the file's unit is, SI."""
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
        rows.units.append(unit)
        rows.places += [(file, int(row)) for row in number]

    def warnings(self) -> list[str]:
        """Return a warning for the rows that repeat others with fewer digits; none where there are no such rows."""
        pairs: list[_Pair] = []
        for layout, rows in self._of_layout.items():
            units = np.repeat(rows.units, [len(piece) for piece in rows.values], axis=0)
            found = _rounded_pairs(np.concatenate(rows.values), units, layout)
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
    >>> last_digits(np.array([12.5, 0.125, 3.0, 620.0, 0.0, 1.0 / 3.0])).tolist()
    [0.1, 0.001, 1.0, 10.0, 0.0, 0.0]
    """
    size = np.zeros(values.shape)
    for digits in range(_MOST_DIGITS, _LEAST_DIGITS - 1, -1):
        scaled = values * 10.0**digits
        size[np.abs(scaled - np.round(scaled)) <= _WHOLE] = 10.0**-digits
    size[(values == 0.0) | ~np.isfinite(values)] = 0.0
    return size


def _rounded_pairs(values: Floats, units: Floats, layout: Layout) -> list[tuple[int, int]]:
    """Return (copy, original) of the rows that repeat another one with fewer digits.

    Parameters
    ----------
    values : (n, c) SI; NaN where there is none. units : (n, c) of the file, SI. layout : of the c columns.
    """
    has_moved = np.repeat([name.partition(".")[0] in _MOVED for name, _ in layout], [count for _, count in layout])
    rows = np.flatnonzero(np.isfinite(values[:, has_moved]).any(axis=1))
    values, units = np.nan_to_num(values[rows]), units[rows]  # a zero has no last digit, and is like a zero alone
    originals = _originals(values, units, layout)
    if not originals or _is_chance(len(originals), values, units, layout):
        return []
    # several rows round to the same where nothing moved: the one as far away as the originals of other copies is meant
    distances = Counter(rows[copy] - rows[original] for copy, own in originals.items() for original in own)
    chosen = {copy: max(own, key=lambda row: distances[rows[copy] - rows[row]]) for copy, own in originals.items()}
    return [(int(rows[copy]), int(rows[original])) for copy, original in chosen.items()]


def _originals(values: Floats, units: Floats, layout: Layout) -> dict[int, list[int]]:
    """Return of each row that repeats others with fewer digits which these are."""
    originals: dict[int, list[int]] = {}
    if len(values) < 2:
        return originals
    digits = units * last_digits(values / units)
    printed = printed_digits(values, digits, layout)
    for own in _of_one_format(digits, layout):
        copy, original = _near_pairs(values, printed, own)
        agree = np.all(np.abs(values[copy] - values[original]) <= _HALF * printed[copy], axis=1)
        agree &= _are_coarser(digits[copy], digits[original], layout)
        for one, other in zip(copy[agree].tolist(), original[agree].tolist(), strict=True):
            originals.setdefault(one, []).append(other)
    return originals


def _is_chance(copies: int, values: Floats, units: Floats, layout: Layout) -> bool:
    """Return whether zeros at the end of readings make so many rows look like copies.

    Readings end in each other digit as often: with as many added to all, those that end in it look like copies, and
    rows that were rounded do not.
    """
    step = _finest(values, units * last_digits(values / units))
    rows, by_chance = len(values), 0
    for k in _LAST_DIGITS:
        by_chance += len(_originals(values + k * step, units, layout))
        if probability_of_as_many(copies, rows, by_chance, k * rows) <= MOST_PROBABLE:
            return False
        if probability_of_as_many(copies, rows, by_chance, _LAST_DIGITS[-1] * rows) > MOST_PROBABLE:
            return True  # also where no more are found
    return True


def _finest(values: Floats, digits: Floats) -> Floats:
    """Return (c,) the last digit of most readings of each column, those that were rounded left aside; 0 of none.

    Where most have all digits that a number holds it is finer than all others.
    """
    finest = np.zeros(values.shape[1])
    for column, (own, sizes) in enumerate(zip(values.T, digits.T, strict=True)):
        known = sizes[sizes > 0.0]
        if known.size:
            finest[column] = np.quantile(sizes[own != 0.0], _FINE, method="lower") or 0.1 * known.min()
    return finest


def _of_one_format(digits: Floats, layout: Layout) -> Iterator[Integers]:
    """Yield the rows that were printed alike: with the same number of digits in each signal.

    Parameters
    ----------
    digits : (n, c) sizes of the last digits. layout : of the c columns.
    """
    bounds = np.cumsum([0, *(count for _, count in layout)])
    known = np.where(digits > 0.0, digits, np.inf)
    finest = np.stack([known[:, start:end].min(axis=1) for start, end in itertools.pairwise(bounds)], axis=1)
    decades = np.round(10.0 * np.log10(finest))  # units of one signal are the same in all rows
    _, group = np.unique(decades, axis=0, return_inverse=True)
    order = np.argsort(group.ravel(), kind="stable")
    yield from np.split(order, np.cumsum(np.bincount(group.ravel()))[:-1])


def _near_pairs(values: Floats, printed: Floats, own: Integers) -> tuple[Integers, Integers]:
    """Return rows of one format and, of each, rows within half of that format's last digits; itself may be one.

    Parameters
    ----------
    values : (n, c) SI. printed : (n, c) as of `printed_digits`. own : (m,) the rows of the format.
    """
    none = np.zeros(0, dtype=np.int64)
    coarse = np.array(
        [np.quantile(known[known > 0.0], _COARSE) if np.any(known > 0.0) else 1.0 for known in printed[own].T]
    )
    scaled = values / coarse
    near = np.flatnonzero(_within_reach(scaled, own))
    is_own = np.isin(near, own, assume_unique=True)
    near, is_own = near[chosen := _near_others(scaled[near], is_own)], is_own[chosen]
    if not len(near):
        return none, none
    from scipy.spatial import cKDTree  # takes longer to load than most tables take to be checked

    own, neighbours = near[is_own], min(_NEIGHBOURS, len(near))
    tree = cKDTree(scaled[near])
    copies, originals = [none], [none]
    for start in range(0, len(own), _ROWS_AT_ONCE):
        asked = own[start : start + _ROWS_AT_ONCE]
        _, found = tree.query(scaled[asked], k=neighbours, p=np.inf, distance_upper_bound=_HALF)
        row, place = np.nonzero((found := np.asarray(found).reshape(len(asked), neighbours)) < len(near))
        copies.append(asked[row])
        originals.append(near[found[row, place]])
    copy, original = np.concatenate(copies), np.concatenate(originals)
    other = copy != original
    return copy[other], original[other]


def _within_reach(scaled: Floats, own: Integers) -> Booleans:
    """Return (n,) True where a row is within `_HALF` of some of its own rows in each column by itself."""
    reached = np.arange(len(scaled))
    for column in scaled.T:
        among = np.sort(column[own])
        behind = np.searchsorted(among, column[reached])
        before, after = among[np.maximum(behind - 1, 0)], among[np.minimum(behind, len(among) - 1)]
        reached = reached[np.minimum(np.abs(column[reached] - before), np.abs(after - column[reached])) <= _HALF]
    chosen = np.zeros(len(scaled), dtype=np.bool_)
    chosen[reached] = True
    return chosen


def _near_others(scaled: Floats, is_own: Booleans) -> Booleans:
    """Return (n,) True where a row may be within `_HALF` of one of its own in every column, itself left aside.

    Column by column, rows stay together that a chain of steps of at most `_HALF` connects: two rows that are near each
    other are never parted, and of measured values few others are left.
    """
    group = np.zeros(len(scaled), dtype=np.int64)
    for column in scaled.T:
        order = np.lexsort((column, group))
        parted = (np.diff(group[order]) != 0) | (np.diff(column[order]) > _HALF)
        group[order] = np.concatenate([[0], np.cumsum(parted)])
    several, with_own = np.bincount(group) > 1, np.bincount(group, weights=is_own) > 0.0
    return np.asarray((several & with_own)[group])


def printed_digits(values: Floats, digits: Floats, layout: Layout) -> Floats:
    """Return the size of the last digit that was printed of each reading (n, c), zeros at the end of it included.

    Readings of one signal are printed with the same number of decimals, or with the same number of digits.

    Parameters
    ----------
    values : (n, c) readings. digits : (n, c) of each as `last_digits` gives it. layout : of the c columns.
    """
    known = np.where(digits > 0.0, digits, np.inf)
    length = np.where(digits > 0.0, np.floor(np.log10(np.maximum(np.abs(values) / known, 1.0))), 0.0)
    printed = np.empty(digits.shape)
    start = 0
    for _, count in layout:
        own = slice(start, start + count)
        decimals = known[:, own].min(axis=1, keepdims=True)
        with_digits = digits[:, own] * 10.0 ** (length[:, own] - length[:, own].max(axis=1, keepdims=True))
        printed[:, own] = np.where(np.isfinite(decimals), np.maximum(decimals, with_digits), 0.0)
        start += count
    return printed


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
