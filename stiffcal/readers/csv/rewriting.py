"""Lines of a text log as the parser wants them: one delimiter between cells, as many cells in each line."""

from __future__ import annotations

import re
from collections.abc import Callable

from stiffcal.table_layout.text import BLANKS, TextLayout, cells_between_blanks

_RUN = re.compile(rb"[ \t]{2,}|\t")
_AT_ENDS = re.compile(rb" *\n *")


def rewriting_of(layout: TextLayout) -> Callable[[bytes], bytes] | None:
    """Return what makes whole lines of a log such lines; None where they are.

    Parameters
    ----------
    layout : of the log.
    """
    if layout.delimiter == BLANKS:
        return _one_blank
    missing = len(layout.columns) - layout.rows.shortest
    if missing <= 0:
        return None
    delimiter = layout.delimiter.encode()
    n_delimiters, rest = layout.rows.shortest - 1, delimiter * missing

    def completed(lines: bytes) -> bytes:
        return b"\n".join(
            line + rest if line and _count(line, delimiter) == n_delimiters else line for line in lines.split(b"\n")
        )

    return completed


def _count(line: bytes, delimiter: bytes) -> int:
    return re.sub(rb'"[^"]*"', b"", line).count(delimiter) if b'"' in line else line.count(delimiter)


def _one_blank(lines: bytes) -> bytes:
    """Return lines with one blank between cells and none at their ends."""
    if b'"' in lines:
        text = lines.decode("latin-1")
        return "\n".join(map(_requoted, text.split("\n"))).encode("latin-1")
    if b"  " in lines or b"\t" in lines:
        lines = _RUN.sub(b" ", lines)
    return _AT_ENDS.sub(b"\n", lines).strip(b" ") if b" \n" in lines or b"\n " in lines else lines.strip(b" ")


def _requoted(line: str) -> str:
    """Return one line with one blank between cells; a cell with blanks in it keeps its quotation marks."""
    cells = cells_between_blanks(line)
    return BLANKS.join('"' + cell.replace('"', '""') + '"' if BLANKS in cell or '"' in cell else cell for cell in cells)
