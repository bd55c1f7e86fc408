"""A header taken apart: the name of a column and its unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from stiffcal.campaign.columns.column_words import TIMES, TIMES_BY_UNIT, XYZ, plain_name
from stiffcal.quantities import is_known, quantities

_NARROW = str.maketrans(
    {chr(0xFEE0 + code): chr(code) for code in range(0x21, 0x7F)} | dict(zip("\u3010\u3011{}", "[][]", strict=True))
)
"""Braces, and signs of double width, as Japanese and Chinese keyboards write them, to usual ones."""
_LONGEST_NAME = 300  # characters; in a longer one no unit is looked for, which takes the square of its length
_BRACKETED = re.compile(r"^(?P<name>.*?)(?:\[(?P<a>[^\]]*+)\]|\((?P<b>[^)]*+)\))\s*+$")
# A unit behind a slash (DIN 1313: "F / kN"), a dash, a word, an underscore or a blank: else part of the name.
_SEPARATED = re.compile(
    r"^(?P<name>.*?\S)(?:(?:\s*/\s*|\s+[-–]\s+)(?P<ratio>[^\s/]++)|(?:\s+in\s+|,\s*|(?P<loose>_|\s+))(?P<unit>[^\s_,]++))\s*+$"
)
_COVERAGE = re.compile(r"k ?= ?\d|\d\d ?%")


@dataclass(frozen=True)
class ColumnHeader:
    """A column's header, taken apart."""

    name: str
    """Without the unit."""
    unit: str | None
    """As written; None where there is none."""


def header_parts(header: str) -> ColumnHeader:
    """Return a header's name and the unit that stands in it.

    Examples
    --------
    >>> headers = "Fx [kN]", "F / N", "Fx/kN", "dx_mm", "Kraft X in kN", "v_deg/s", "Fx_N", "F_N", "ms", "note"
    >>> for parts in map(header_parts, headers):
    ...     print(parts.name, parts.unit, sep=", ")
    Fx, kN
    F, N
    Fx, kN
    dx, mm
    Kraft X, kN
    v, deg/s
    Fx, N
    F_N, None
    ms, ms
    note, None
    """
    if len(header) > _LONGEST_NAME:
        return ColumnHeader(header, None)
    if header.lower() in TIMES_BY_UNIT and is_unit(header):
        return ColumnHeader(header, header)
    header = header.translate(_NARROW)
    bracketed = _BRACKETED.match(header)
    within = (bracketed["a"] or bracketed["b"] or "").strip() if bracketed is not None else ""
    if bracketed is not None and not within.isdigit() and not _COVERAGE.fullmatch(within):  # q[0] is a name
        return ColumnHeader(bracketed["name"].strip(), within or None)
    separated = _SEPARATED.match(header)
    if separated is not None:
        written, name = separated["ratio"] or separated["unit"], separated["name"]
        # one letter after an underscore or a blank completes a name, as in F_N, unless an axis or a number is its end
        complete = len(written) > 1 or separated["loose"] is None or name[-1].lower() in XYZ or name[-1].isdigit()
        complete = complete or (written == "s" and plain_name(name) in TIMES)
        if complete and is_unit(written):
            return ColumnHeader(name.strip(), written)
    return ColumnHeader(header, None)


@lru_cache(maxsize=4096)
def is_unit(text: str) -> bool:
    """Return whether a text is a unit of any quantity."""
    return any(is_unit_of(text, quantity) for quantity in quantities())


# Units of what is not computed with, as rows of units hold them too; with those of mechanics also as parts of products.
_OTHER_UNITS = frozenset(
    (
        *("s", "sec", "ms", "us", "ns", "min", "h", "n", "kn", "mn", "nm", "knm", "nmm", "ncm", "m", "mm", "cm", "um"),
        *("deg", "°", "rad", "mrad", "urad", "rev", "turn", "a", "ma", "v", "mv", "w", "kw", "degc", "°c", "c", "k"),
        *("kg", "g", "hz", "khz", "rpm", "pa", "kpa", "mpa", "bar", "mbar", "lbf", "in", "%", "iso8601", "counts"),
    )
)


def is_unit_word(text: str) -> bool:
    """Return whether a cell is a unit, also one that nothing is computed with, or a product of units; no number is."""
    factors = [factor.rstrip("²³23^-") for factor in re.split(r"[*·./ ]", text.lower().replace("µ", "u")) if factor]
    return is_unit(text) or (bool(factors) and all(factor in _OTHER_UNITS for factor in factors))


def is_unit_of(text: str, quantity: str) -> bool:
    """Return whether a text is a unit of a quantity."""
    return is_known(text, quantity)


def bare_unit(cell: str) -> str:
    """Return a cell of a row of units without brackets."""
    return cell.translate(_NARROW).strip("[]() ")


def is_unit_row(row: Sequence[str]) -> bool:
    """Return whether every cell of a row is a unit or empty, and some are units."""
    cells = [bare_unit(cell) for cell in row]
    without = {"-", "[-]", "(-)", "[1]", "(1)"}  # of a number without a dimension
    return any(map(is_unit_word, cells)) and all(
        not cell or written in without or is_unit_word(cell) for cell, written in zip(cells, row, strict=True)
    )
