"""Names of columns that stand in several rows: a body, what is measured of it, and its component below each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from stiffcal.campaign.columns.column_headers import header_parts, is_unit_of
from stiffcal.campaign.columns.column_names import Reading, component_of
from stiffcal.campaign.columns.column_words import TIMES, plain_name

_COMPONENTS = frozenset(("x", "y", "z", "w", "qx", "qy", "qz", "qw", "rx", "ry", "rz"))
XYZ_NAMES = ("x", "y", "z")
_NAME_LABELS = frozenset(("name", "names", "marker", "markers", "body", "bodies", "label", "labels"))
"""What stands before a row of names in an export whose rows of the header are labelled."""


def composed_names(names: Sequence[str], above: Sequence[Sequence[str]]) -> tuple[list[str], dict[str, str]]:
    """Return unique names for columns, with words of the rows above where those of the last row repeat.

    Of the rows above, as few are taken as make the names unique: those labelled as names first, then the nearest. A
    cell above several columns (merged in a spreadsheet) counts for those to its right that have none.

    Parameters
    ----------
    names : the cells of the header's last row. above : the rows above it, top to bottom.

    Returns
    -------
    list of str, dict of str to str
        The names, as they are where they are unique already, and units that stand in a row above.

    Examples
    --------
    >>> composed_names(["t", "X", "Y", "X", "Y"], [["", "tool", "", "base", ""]])[0]
    ['t', 'tool X', 'tool Y', 'base X', 'base Y']
    >>> composed_names(["X", "X"], [["Force [N]", "Moment [Nm]"]])
    (['Force X', 'Moment X'], {'Force X': 'N', 'Moment X': 'Nm'})
    >>> composed_names(["", "", "X1", "Y1"], [["Frame#", "Time", "probe", ""]])[0]
    ['Frame#', 'Time', 'X1', 'Y1']
    >>> composed_names(["", "x", "y", "z"], [["t", "Force [N]", "", ""]])
    (['t', 'Force x', 'Force y', 'Force z'], {'Force x': 'N', 'Force y': 'N', 'Force z': 'N'})
    >>> composed_names(["s", "Fx [N]", "Fy [N]"], [["Time", "ATI", ""]])
    (['Time', 'Fx [N]', 'Fy [N]'], {'Time': 's'})
    """
    names, units = _named_above_their_units(names, above)
    counts = Counter(names)
    if all(count == 1 or not name for name, count in counts.items()):
        found, more = _with_what_is_measured(names_with_those_above(names, above), above)
        return found, units | more
    repeated = [k for k, name in enumerate(names) if not name or counts[name] > 1 or name.lower() in _COMPONENTS]
    rows = [_spread(row, repeated, len(names)) for row in above]
    labels = [_label(row, repeated) in _NAME_LABELS for row in above]
    candidates = sorted(range(len(above)), key=lambda k: (not labels[k], -k))
    chosen: list[int] = []
    for k in candidates:
        if _distinct(names, rows, repeated, [*chosen, k]) > _distinct(names, rows, repeated, chosen):
            chosen.append(k)
    composed = list(names)
    for c in repeated if chosen else ():
        parts = [header_parts(rows[k][c]) for k in sorted(chosen) if rows[k][c]]
        own = header_parts(names[c])
        composed[c] = " ".join(word for word in (*(part.name for part in parts), own.name) if word)
        unit = own.unit or next((part.unit for part in reversed(parts) if part.unit), None)
        if unit is not None and composed[c]:
            units[composed[c]] = unit
    return composed, units


def _named_above_their_units(names: Sequence[str], above: Sequence[Sequence[str]]) -> tuple[list[str], dict[str, str]]:
    """Return names, that of the row above where nothing but a unit stands in the last row, and these units."""
    found, units = list(names), {}
    last = above[-1] if above else []
    for c, (name, cell) in enumerate(zip(names, last if sum(map(bool, last)) > 1 else [], strict=False)):
        part = header_parts(name)
        is_unit = not part.name if part.unit is not None else plain_name(cell) in TIMES and is_unit_of(name, "time")
        if is_unit and cell and cell not in names:
            found[c], units[cell] = cell, part.unit or name
    return found, units


def _with_what_is_measured(names: list[str], above: Sequence[Sequence[str]]) -> tuple[list[str], dict[str, str]]:
    """Return names that are unique, axes alone with the cell above that says what is measured along them.

    By themselves x, y, z are a place: "force" above them is no name of a target, as a word that means nothing is.
    """
    axes = [c for c, name in enumerate(names) if name.lower() in XYZ_NAMES]
    found = list(names)
    units: dict[str, str] = {}
    for row in reversed(above if len(axes) == len(XYZ_NAMES) else ()):
        spread = _spread(row, axes, len(names))
        for c in axes:
            part = header_parts(spread[c])
            meant = component_of(f"{part.name} {names[c]}", part.unit) if part.name else None
            if found[c] == names[c] and meant is not None and meant.reading is not Reading.POSITION:
                found[c] = f"{part.name} {names[c]}"
                units |= {} if part.unit is None else {found[c]: part.unit}
    return found, units


def names_with_those_above(names: Sequence[str], above: Sequence[Sequence[str]]) -> list[str]:
    """Return names with those of the row right above for columns that have none of their own (.trc: frame, time)."""
    last = list(above[-1]) if above else []
    taken = set(names)
    if sum(map(bool, last)) < 2:  # a title
        return list(names)
    return [
        name or (cell if cell not in taken and last.count(cell) == 1 else "")
        for name, cell in zip(names, [*last, *[""] * len(names)], strict=False)
    ]


def _spread(row: Sequence[str], repeated: Sequence[int], width: int) -> list[str]:
    """Return a row above with each cell also in the empty ones to its right, as far as these columns need a name."""
    cells = [*row[:width], *[""] * (width - len(row))]
    merged = sum(1 for c in repeated if not cells[c]) * 2 >= len(repeated)  # most are empty: cells were merged
    own, kept = [""] * width, ""
    for c in repeated:
        kept = cells[c] or (kept if merged else "")
        own[c] = kept
    return own


def _label(row: Sequence[str], repeated: Sequence[int]) -> str:
    """Return the label of a row of a header: the last cell before the columns that it is about."""
    before = [cell for cell in row[: repeated[0]] if cell]
    return before[-1].lower() if before else ""


def _distinct(names: Sequence[str], rows: Sequence[Sequence[str]], repeated: Sequence[int], chosen: list[int]) -> int:
    return len({(*(rows[k][c] for k in chosen), names[c]) for c in repeated})
