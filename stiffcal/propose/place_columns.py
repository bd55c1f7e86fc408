"""Columns of measured targets by their names: one target or several, and the uncertainty of each reading."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from stiffcal.campaign.columns.column_words import words_of
from stiffcal.propose.table_sniffing import SniffedColumn

_UNCERTAINTY = ("sigma", "uncertainty", "unsicherheit", "unc", "u")
_EXPANDED: Mapping[str, float] = MappingProxyType({"95": 2.0, "u95": 2.0, "k1": 1.0, "k2": 2.0, "k3": 3.0})
"""What stands with an expanded uncertainty, and its coverage factor: U(95) is a level of confidence (GUM, 6.2)."""
_SCATTER = ("std", "stddev", "stdev", "stabw", "sd", "scatter", "streuung")
_JOINED = re.compile(rf"({'|'.join(_UNCERTAINTY + _SCATTER)}|s)(?P<of>[xyz]\d*|xyz)")
_ALL_AXES = "xyz"
_NUMBERED = re.compile(r"(?P<name>[a-z]*?)(?P<axis>[xyz])(?P<number>\d+)")
_BODY = re.compile(
    r"(?P<kind>led|marker|smr|reflector|reflektor|prism|prisma|probe|tmac|tprobe|target|ziel|p|pt|point|punkt|messpunkt)"
    r"(?P<number>\d+)"
)
_BARE = ("", "p", "pos", "position", "target", "point", "punkt", "marker", "smr")
_STEADY = 4.0
"""Ratio of the 95 % to the 5 % quantile up to which columns of a standard deviation describe the instrument.

Distances from 1 to 4 m make this of a tracker's or a camera's. A wider spread is that of standard deviations, each of a
few samples: they state how steady one reading was, not by how much places of two readings differ."""


@dataclass(frozen=True)
class SigmaColumns:
    """Columns with the uncertainty of readings."""

    columns: tuple[SniffedColumn, ...]
    """One, for all axes, or three."""
    steady: bool
    """Whether they describe the instrument; otherwise they only state how much each reading scattered."""
    coverage: float = 1.0
    """How many standard uncertainties they hold."""
    zero_rows: int = 0
    """Rows in which one is 0, which states nothing."""


@dataclass(frozen=True)
class TargetColumns:
    """Three coordinates of a target."""

    name: str
    """A frame's name, from the columns' names."""
    columns: tuple[SniffedColumn, ...]
    """x, y, z."""


def numbered_targets(words: dict[SniffedColumn, str]) -> tuple[TargetColumns, ...]:
    """Return the targets of a table that measures several, in the order of their numbers; empty where it does not.

    Parameters
    ----------
    words : columns of numbers that are nothing else, each with its bare name (``smr1x``, ``x1``).

    Examples
    --------
    >>> names = [f"{axis}{number}" for number in (1, 2) for axis in "xyz"]
    >>> [target.name for target in numbered_targets({SniffedColumn(n, n, None, (0.0,)): n for n in names})]
    ['target1', 'target2']
    """
    complete = _complete(words)
    for kind in dict.fromkeys(kind for kind, _ in complete):
        numbers = sorted(number for own, number in complete if own == kind)
        if len(numbers) > 1:
            name = kind if kind not in ("", "p", "pos", "position", "point", "punkt") else "target"
            return tuple(
                TargetColumns(f"{name}{number}", tuple(complete[kind, number][axis] for axis in "xyz"))
                for number in numbers
            )
    return ()


def single_target(words: dict[SniffedColumn, str]) -> tuple[SniffedColumn, ...]:
    """Return x, y and z of the only target of a table that numbers it all the same; empty where there is no such one.

    Parameters
    ----------
    words : columns of numbers that are nothing else, each with its bare name (``smr1x``, ``x1``).

    Examples
    --------
    >>> [c.name for c in single_target({SniffedColumn(n, n, None, (0.0,)): n for n in ("x1", "y1", "z1", "s1")})]
    ['x1', 'y1', 'z1']
    """
    complete = list(_complete(words).values())
    return tuple(complete[0][axis] for axis in "xyz") if len(complete) == 1 else ()


def _complete(words: dict[SniffedColumn, str]) -> dict[tuple[str, int], dict[str, SniffedColumn]]:
    """Return the columns of each axis by the stem and the number of their names, where all three axes are there."""
    found: dict[tuple[str, int], dict[str, SniffedColumn]] = {}
    for column, word in words.items():
        after = _NUMBERED.fullmatch(word)
        before = _BODY.fullmatch(word[:-1])
        if before is not None and word[-1] in "xyz":
            found.setdefault((before["kind"], int(before["number"])), {})[word[-1]] = column
        elif after is not None and after["name"] in _BARE:
            found.setdefault((after["name"], int(after["number"])), {})[after["axis"]] = column
    return {key: axes for key, axes in found.items() if len(axes) == 3}


def sigma_columns(words: dict[SniffedColumn, list[str]]) -> dict[str, SniffedColumn]:
    """Return the columns that hold the uncertainty of readings, by the bare name of what they belong to.

    Parameters
    ----------
    words : columns with the words of their names, in small letters.

    Examples
    --------
    >>> words = ["std", "marker", "x"], ["sigmax"], ["sy1"], ["uncertainty"], ["marker", "x"]
    >>> list(sigma_columns({SniffedColumn(str(own), "", None, (0.1,)): own for own in words}))
    ['markerx', 'x', 'y1', '']
    """
    found: dict[str, SniffedColumn] = {}
    for column, pieces in words.items():
        pieces = _with_factors(pieces)
        expanded = [piece for piece in pieces if piece in _EXPANDED]
        if "u" in pieces and not expanded:  # a displacement
            continue
        kept = [piece for piece in pieces if piece not in (*_UNCERTAINTY, *_SCATTER, *expanded)]
        joined = _JOINED.fullmatch("".join(piece for piece in pieces if piece not in expanded))
        if joined is not None or len(kept) < len(pieces):
            of = joined["of"].removeprefix(_ALL_AXES) if joined is not None else "".join(kept)
            found.setdefault(of, column)
    return found


def _with_factors(words: Sequence[str]) -> list[str]:
    """Return the words of a name with a coverage factor as one: "k=2" is of two words."""
    return re.sub(r"\bk (\d)\b", r"k\1", " ".join(words)).split()


def sigma_of(names: Sequence[str], sigma: dict[str, SniffedColumn], of_all: bool = True) -> SigmaColumns | None:
    """Return the columns with the uncertainty of three readings, None where there are none.

    Columns with a value that is not positive are no such columns.

    Parameters
    ----------
    names : bare names of x, y, z. sigma : as `sigma_columns` returns them.
    of_all : whether columns that are called after the axes alone, or after nothing, are theirs too.
    """
    stems = {re.sub(r"[xyz](\d*)$", r"\1", name) for name in names}
    choices = [tuple(names), *((stem,) for stem in sorted(stems) if stem)]
    common = {name[:-1] for name in sigma if name[-1:] in ("x", "y", "z")}  # one set for whatever is measured
    choices += [tuple(f"{stem}{axis}" for axis in "xyz") for stem in common] if of_all and len(common) == 1 else []
    choices += [("",)] if of_all else []
    for choice in choices:
        columns = tuple(sigma[name] for name in choice if name in sigma)
        if len(columns) == len(choice) and all(_is_positive(column) for column in columns):
            words = {word for column in columns for word in _with_factors(words_of(column.name)[0])}
            coverage = max((_EXPANDED[word] for word in words & _EXPANDED.keys()), default=1.0)
            zeros = sum(1 for row in zip(*(column.values for column in columns), strict=False) if min(row) == 0.0)
            return SigmaColumns(columns, _is_steady(columns), coverage, zeros)
    return None


def _is_positive(column: SniffedColumn) -> bool:
    """Return whether a column of uncertainties holds any, and nothing below 0."""
    return bool(_finite(column)) and min(_finite(column)) >= 0.0 < max(_finite(column))


def _finite(column: SniffedColumn) -> list[float]:
    """Return the values where a target was measured."""
    return [value for value in column.values if math.isfinite(value)]


def _is_steady(columns: Sequence[SniffedColumn]) -> bool:
    """Return whether columns of uncertainties describe the instrument, by their names or by how little they vary."""
    stated = [any(word in column.name.lower() for word in _UNCERTAINTY) for column in columns]
    positive = [[value for value in _finite(column) if value > 0.0] for column in columns]
    spread = [np.quantile(values, 0.95) / np.quantile(values, 0.05) for values in positive]
    return all(stated) or bool(max(spread) <= _STEADY)
