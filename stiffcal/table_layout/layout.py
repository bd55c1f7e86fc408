"""The layout of a table: which row holds the names, how several rows of a header make one name, where the data begin.

One reading for what is written by hand, by spreadsheets, loggers and motion capture: rows of names stand right above
rows of numbers, with units between, in brackets or in a row of their own; lines that state something stand above.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from stiffcal.campaign.columns.column_headers import bare_unit, header_parts, is_unit_row
from stiffcal.measurements.scope_export import NAME, PROPERTIES, is_scope_header, scope_columns, scope_units
from stiffcal.table_layout.cells import is_gap, is_reading, marks_of
from stiffcal.table_layout.composed_names import composed_names, names_with_those_above
from stiffcal.table_layout.key_lines import body_names, length_unit_of, marker_names, rate_of

COMMENT_SIGNS = ("#", "%", "//", ";", "!")
"""What begins a line of names in files of numerical programs (``np.savetxt`` writes "# ")."""
NAMELESS = "column"
"""Columns of a table without a header are called column1, column2 …"""

# Of its columns a row of names fills so many, and of its cells so few are numbers.
_FILLED, _FEW_NUMBERS = 0.8, 0.2
_HALF = 0.5  # of the columns a row names that leaves the others to the row above
_MOSTLY = 0.6


@dataclass(frozen=True)
class Layout:
    """How the rows of a table are laid out."""

    columns: tuple[str, ...]
    """The names, in order; "" of a column without one."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Column name to the unit that a row of units, or a line above, states."""
    header_row: int | None = None
    """The row with the names, from 0; None where the table has none."""
    first_data_row: int = 0
    """The first row that can hold data, from 0."""
    shortest: int = 0
    """Cells of a row of data that leaves out the last ones, or as many as there are columns."""
    decimal: str = "."
    """The decimal mark of numbers."""
    thousands: str = ""
    """The mark between groups of three digits, "" where there is none."""
    rate_hz: float | None = None
    """Rows per second, where lines above the header state it."""
    has_unit_row: bool = False
    """Whether a row below the names holds units."""
    holds_numbers: bool = False
    """Whether rows of numbers were seen."""


def layout_of_rows(
    rows: Sequence[Sequence[str]],
    *,
    wanted: Collection[str] = (),
    header_row: int | None = None,
    unit_row: bool | None = None,
    decimal: str | None = None,
) -> Layout:
    """Return the layout of a table by its first rows.

    Parameters
    ----------
    rows : cells without blanks around them; an empty line is an empty row.
    wanted : names that are expected: a row that holds them all is the header, whatever else speaks for another.
    header_row : the row with the names, where it is known.
    unit_row : whether the row below the names holds units; None: decided by that row.
    decimal : the decimal mark, where it is known.

    Examples
    --------
    >>> found = layout_of_rows([["Take 1"], [], ["t", "Fx"], ["s", "N"], ["0", "1,5"], ["1", "2,5"]])
    >>> found.columns, found.units["Fx"], found.header_row, found.first_data_row, found.decimal
    (('t', 'Fx'), 'N', 2, 4, ',')
    >>> layout_of_rows([["1.5", "2"], ["1.6", "3"]]).columns
    ('column1', 'column2')
    """
    kinds = _Kinds(rows, decimal)
    if header_row is None and (bodies := _of_bodies(rows, kinds)) is not None:
        return bodies
    names_row = header_row if header_row is not None else _names_row(rows, kinds, wanted)
    if names_row is None:
        return _nameless(rows, kinds, wanted)
    names = without_comment_sign(rows[names_row], kinds.width)
    as_wide = kinds.width in (0, len(names))
    if names[:1] == [NAME] and as_wide and (scope := _scope(rows, names_row, names, kinds)) is not None:
        return scope
    above = rows[max(0, names_row - _HIGHEST_HEADER) : names_row]
    names, composed_units = composed_names(names, above)
    below, units = _units_below(rows, names_row, names, unit_row)
    if not units and unit_row is None:
        units = _units_above(above, len(names))
    if not any(kinds.used[len(names) :]):  # cells beyond the names are empty in all rows: columns without a name
        names += [""] * (kinds.width - len(names))
    unit_of = composed_units | {name: unit for name, unit in zip(names, units, strict=False) if name and unit}
    length = length_unit_of(rows[:names_row])
    if length is not None:
        unit_of |= {name: length for name in names if name not in unit_of and _is_place(name)}
    return Layout(
        columns=tuple(names),
        units=unit_of,
        header_row=names_row,
        first_data_row=below,
        shortest=kinds.width if kinds.n_rows >= _FEWEST_SHORT and kinds.width < len(names) else len(names),
        decimal=kinds.decimal,
        thousands=kinds.thousands,
        rate_hz=rate_of(rows[:names_row]),
        has_unit_row=below > names_row + 1,
        holds_numbers=kinds.n_rows > 0,
    )


# Rows that leave out the last cells are a way to write; a single one was cut off.
_FEWEST_SHORT = 2
# Rows of a header above its last one; Motive writes five.
_HIGHEST_HEADER = 8


class _Kinds:
    """Which rows hold data: what most rows of the table's usual width have in common."""

    def __init__(self, rows: Sequence[Sequence[str]], decimal: str | None) -> None:
        self._rows = rows
        mark, self.thousands = marks_of(cell for row in rows for cell in row)
        if decimal is not None and decimal != mark:
            mark, self.thousands = decimal, ""
        self.decimal = mark
        self._readings = [[self._is_reading(cell) for cell in row] for row in rows]
        widths: Counter[int] = Counter()
        for row, found in zip(rows[self._first_below() :], self._readings[self._first_below() :], strict=True):
            widths[len(row)] += sum(found)
        self.width = max(widths, key=lambda width: (widths[width], width)) if widths.total() else 0
        data = [k for k, row in enumerate(rows) if len(row) == self.width and any(self._readings[k])]
        filled = [sum(1 for k in data if rows[k][c]) for c in range(self.width)]
        numbers = [sum(1 for k in data if self._readings[k][c]) for c in range(self.width)]
        self.numeric = [2 * count > total > 0 for count, total in zip(numbers, filled, strict=True)]
        self.used = [any(rows[k][c] for k in data) for c in range(self.width)]
        """Whether a column holds anything in rows of numbers."""
        self.n_rows = len(data)
        self._begins_with_words = bool(data) and 2 * (filled[0] - numbers[0]) > len(data)

    def _first_below(self) -> int:
        """Return the first row below the last one that holds words only, above numbers."""
        numbers = [any(found) for found in self._readings]
        last = max((k for k, own in enumerate(numbers) if own), default=0)
        return max((k + 1 for k in range(last) if not numbers[k] and any(self._rows[k])), default=0)

    def _is_reading(self, cell: str) -> bool:
        return bool(cell) and (is_reading(cell, self.decimal, self.thousands) or is_gap(cell))

    def is_data(self, k: int) -> bool:
        """Return whether row k holds data: of its cells in columns of numbers most are numbers."""
        row, found = self._rows[k], self._readings[k]
        if len(row) != self.width or sum(map(bool, row)) < 2 < self.width:  # a rate alone stands above a table
            return False
        own = [found[c] for c in range(self.width) if self.numeric[c] and row[c]]
        return bool(own) and sum(own) >= _MOSTLY * len(own)

    def is_key_line(self, k: int) -> bool:
        """Return whether row k names what its numbers are, as lines above a table do ("Delta_X", 0.02, 0.02)."""
        first = next((c for c, cell in enumerate(self._rows[k]) if cell), None)
        if first is None or self._readings[k][first]:
            return False
        # of a row that begins with empty cells the word stands where all data have numbers
        return not self._begins_with_words if first == 0 else first < self.width and self.numeric[first]

    def first_data(self) -> int | None:
        """Return the first row that holds data and states nothing about the table; None where there is none."""
        return next((k for k in range(len(self._rows)) if self.is_data(k) and not self.is_key_line(k)), None)

    def is_names(self, k: int) -> bool:
        """Return whether row k may hold names of the columns: it fills them, with words."""
        row = without_comment_sign(self._rows[k], self.width)
        n_numbers = sum(self._is_reading(cell) for cell in row if not is_gap(cell))
        filled = [c for c, cell in enumerate(row) if cell]
        if not filled or n_numbers > _FEW_NUMBERS * len(filled) or not self.width:
            return False
        if len(row) > self.width + 1 and any(row[self.width + 1 :]):
            return False
        columns = [c for c in range(self.width) if self.used[c]] or list(range(self.width))
        if columns[0] == 0 and not row[0]:  # the column of a row's number has no name
            columns = columns[1:]
        own = sum(1 for c in columns if c < len(row) and row[c])
        # .trc: frame and time have their names in the row above
        if k and own >= _HALF * len(columns):
            words = [
                "" if found else cell for cell, found in zip(self._rows[k - 1], self._readings[k - 1], strict=True)
            ]
            row = names_with_those_above(row, [words])
        return sum(1 for c in columns if c < len(row) and row[c]) >= _FILLED * len(columns)


def without_comment_sign(row: Sequence[str], width: int) -> list[str]:
    """Return a row of names without the sign that marks its line as none of numbers.

    Examples
    --------
    >>> without_comment_sign(["#", "A1", "A2"], 2), without_comment_sign(["# A1", "A2"], 2)
    (['A1', 'A2'], ['A1', 'A2'])
    """
    for sign in COMMENT_SIGNS if row else ():
        if row[0] == sign and len(row) > 1 and len(row) != width:
            return list(row[1:])
        if row[0].startswith(sign + " ") or (sign in "#%" and row[0].startswith(sign) and len(row[0]) > 1):
            bare = row[0][len(sign) :].strip()
            return [bare, *row[1:]] if bare and not bare.startswith(sign) else list(row)
    return list(row)


def _names_row(rows: Sequence[Sequence[str]], kinds: _Kinds, wanted: Collection[str]) -> int | None:
    """Return the row of names with most rows of data below it; None where none has any, or more stand above all."""
    pairs = (k for k in range(len(rows) - 1) if len(rows[k]) == kinds.width or not kinds.width)
    scope = next((k for k in pairs if is_scope_header(rows[k], rows[k + 1])), None)
    if scope is not None:
        return scope
    data = [kinds.is_data(k) for k in range(len(rows))]
    if wanted:
        for k, row in enumerate(rows):
            if set(wanted) <= set(without_comment_sign(row, kinds.width)):
                # a header that is repeated below data is not theirs: the first line is said to lack the names
                above = any(own and not kinds.is_key_line(i) for i, own in enumerate(data[:k]))
                return next((i for i, own in enumerate(rows) if any(own)), k) if above else k
    named = [not data[k] and kinds.is_names(k) for k in range(len(rows))]
    blocks: list[tuple[int, list[str], int | None]] = []  # rows of data, names, row of names
    count, block = 0, None
    for k in range(len(rows)):
        if named[k] and not (block is not None and k == block + 1 and is_unit_row(rows[k])):
            if block is None or count or not _is_better(rows, k, block, kinds.width):
                blocks.append((count, list(rows[block]) if block is not None else [], block))
            block, count = (k, 0) if block is None or count or _is_better(rows, k, block, kinds.width) else (block, 0)
        elif data[k]:
            count += 1
    blocks.append((count, list(rows[block]) if block is not None else [], block))
    most = max(count for count, _, _ in blocks)
    names = next(own for count, own, _ in blocks if count == most)
    return next(row for count, own, row in blocks if own == names and (count or row is not None or not most))


def _is_better(rows: Sequence[Sequence[str]], k: int, block: int, width: int) -> bool:
    """Return whether of two rows of a header the lower one holds the names: unless only the upper has none twice."""
    lower, upper = ([cell for cell in without_comment_sign(rows[i], width) if cell] for i in (k, block))
    components = {cell.lower() for cell in lower} & set("xyz")
    return bool(components) or len(set(lower)) == len(lower) or len(set(upper)) < len(upper)


def _nameless(rows: Sequence[Sequence[str]], kinds: _Kinds, wanted: Collection[str]) -> Layout:
    """Return the layout of a table without a row of names: a line may list its markers, else columns are numbered."""
    first = kinds.first_data()
    if first is None:  # no numbers at all: the first row that says something is what there is
        header = next((k for k, row in enumerate(rows) if any(row)), None)
        names = without_comment_sign(rows[header], 0) if header is not None else []
        below = 0 if header is None else header + 1
        return Layout(tuple(names), {}, header, below, len(names), kinds.decimal, kinds.thousands)
    names_of = marker_names(rows[:first], kinds.width)
    names = list(names_of) or [f"{NAMELESS}{k + 1}" for k in range(kinds.width)]
    length = length_unit_of(rows[:first])
    units = {name: length for name in names_of if _is_place(name)} if length is not None else {}
    return Layout(
        tuple(names),
        units,
        None,
        first,
        kinds.width,
        kinds.decimal,
        kinds.thousands,
        rate_of(rows[:first]),
        holds_numbers=True,
    )


def _of_bodies(rows: Sequence[Sequence[str]], kinds: _Kinds) -> Layout | None:
    """Return the layout of a table whose bodies a line above lists; None where none lists them."""
    width = max((c + 1 for c, used in enumerate(kinds.used) if used), default=0)
    first = kinds.first_data()
    names = body_names(rows[:first], width)
    if first is None or not names:
        return None
    return Layout(
        columns=names,
        header_row=None,
        first_data_row=first,
        shortest=width,
        decimal=kinds.decimal,
        thousands=kinds.thousands,
        rate_hz=rate_of(rows[:first]),
        holds_numbers=True,
    )


def _units_below(
    rows: Sequence[Sequence[str]], header: int, names: Sequence[str], asked: bool | None
) -> tuple[int, list[str]]:
    """Return the first row below the names and the units, and these; empty where there are none.

    Columns without a unit have empty cells there, also where none but these are wanted.
    """
    if asked is False or header + 1 >= len(rows):
        return header + 1, []
    row = [bare_unit(cell) for cell in without_comment_sign(rows[header + 1], len(names))]
    if row and row[0].lower() in _UNIT_LABELS:
        row[0] = ""
    if asked or (is_unit_row(row) and len(row) <= len(names) + 1):
        return _below_descriptions(rows, header + 2), row
    return header + 1, []


_UNIT_LABELS = ("unit", "units", "einheit", "einheiten", "unité", "unités", "unidad", "unità", "単位", "单位")
_DESCRIPTION = re.compile(r"[^\W\d][^:]{0,30}: ?\S.{0,100}")


def _below_descriptions(rows: Sequence[Sequence[str]], first: int) -> int:
    """Return the first row, from one on, that is not of key and value in each cell ("SN: 1"): of HBM's catman."""
    while first < len(rows) and any(rows[first]) and all(_DESCRIPTION.fullmatch(cell) for cell in rows[first] if cell):
        first += 1
    return first


def _units_above(above: Sequence[Sequence[str]], width: int) -> list[str]:
    """Return the units of a row above the names: a label, and units under which the columns stand."""
    for row in reversed(above):
        if abs(len(row) - width) <= 1 and row and bare_unit(row[0]) != "" and is_unit_row(["", *row[1:]]):
            cells = [bare_unit(cell) for cell in row]
            return ["", *cells[1:]] if not is_unit_row(cells) else cells
    return []


def _is_place(name: str) -> bool:
    """Return whether a name is that of a coordinate without a unit of its own."""
    parts = header_parts(name)
    words = parts.name.lower().replace("_", " ").split()
    return (
        parts.unit is None
        and bool(words)
        and words[-1].rstrip("0123456789") in ("x", "y", "z")
        and "rotation" not in words
    )


def _scope(rows: Sequence[Sequence[str]], header: int, names: Sequence[str], kinds: _Kinds) -> Layout | None:
    """Return the layout of a scope's export, whose rows of properties stand below the names; None where it is none."""
    if header + 1 >= len(rows) or not is_scope_header(names, rows[header + 1]):
        return None
    columns = scope_columns(names)
    below = next((k for k in range(header + 1, len(rows)) if any(rows[k]) and rows[k][0] not in PROPERTIES), len(rows))
    written = next((row for row in rows[header:below] if row and row[0] == "Unit"), [])
    return Layout(
        columns,
        scope_units(names, columns, written),
        header,
        below,
        len(columns),
        kinds.decimal,
        kinds.thousands,
        holds_numbers=True,
    )
