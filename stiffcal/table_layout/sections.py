"""Tables below each other in one text, each under a line of its own that names it: the sections of Vicon Nexus.

Devices, joints, segments and trajectories have a rate and columns of their own. A line that holds nothing ends a table.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from stiffcal.table_layout.cells import is_reading

MOST_SECTIONS = 100
"""Of a text."""
GAP_LINE = re.compile(rb"^[ \t,;]*\n", re.MULTILINE)
"""A line that holds nothing; a spreadsheet writes the delimiters of its empty cells."""
_GAP_TEXT = re.compile(r"[ \t,;]*")
_DELIMITERS = re.compile(r"[,;\t]")


def titles_of_sections(lines: Iterable[str]) -> list[str]:
    """Return the names of a text's tables, where it begins with one that has a name; empty where there are none.

    Examples
    --------
    >>> titles_of_sections(["Devices", "1000", "Frame,Fx", ",N", "1,0.5", "", "Trajectories", "100", "Frame,X", "1,2"])
    ['Devices', 'Trajectories']
    >>> titles_of_sections(["Frame,Fx", "1,0.5", "", "Remarks", "windy"])
    []
    """
    titles: list[str] = []
    title, has_names, begins, first = "", False, True, True
    for line in lines:
        if _GAP_TEXT.fullmatch(line):
            begins = True
            continue
        cells = [cell.strip(' "') for cell in _DELIMITERS.split(line)]
        filled = [cell for cell in cells if cell]
        if begins:
            title = filled[0] if len(filled) == 1 and not is_reading(filled[0], ".", "") else ""
            if first and not title:
                return []
            has_names, begins, first = False, False, False
        elif title and len(filled) > 1:
            if not any(is_reading(cell, ".", "") for cell in filled):
                has_names = True
                continue
            if has_names:
                titles.append(title)
            title = ""
            if len(titles) >= MOST_SECTIONS:
                break
    return titles


def title_line(title: str, encoding: str = "utf-8") -> re.Pattern[bytes]:
    """Return the pattern of the line that names a table."""
    return re.compile(rb'^[ \t]*"?' + re.escape(title.encode(encoding, "replace")) + rb'"?[ \t,;]*$', re.MULTILINE)


def first_table(text: str) -> str:
    r"""Return a text up to the line that ends its first table.

    Examples
    --------
    >>> first_table("Devices\n1000\nFrame,Fx\n1,0.5\n\nTrajectories\n")
    'Devices\n1000\nFrame,Fx\n1,0.5\n'
    """
    at, holds_numbers = 0, False
    for line in text.splitlines(keepends=True):
        if holds_numbers and _GAP_TEXT.fullmatch(line.rstrip("\r\n")):
            return text[:at]
        cells = _DELIMITERS.split(line.strip())
        holds_numbers = holds_numbers or (len(cells) > 1 and any(is_reading(c.strip(), ".", "") for c in cells))
        at += len(line)
    return text
