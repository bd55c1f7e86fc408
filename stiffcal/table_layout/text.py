"""Text that holds a table: its encoding, what stands between its cells, its lines as rows of cells."""

from __future__ import annotations

import codecs
import csv
import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache

from stiffcal.campaign.columns.column_names import WORDS_OF_LETTERS, WORDS_OF_SIGNS
from stiffcal.table_layout.cells import is_gap, is_reading, marks_of, number
from stiffcal.table_layout.layout import Layout, layout_of_rows, without_comment_sign

FIRST_BYTES = 1 << 16
"""So many bytes of a text show how it is laid out."""
BLANKS = " "
"""As a delimiter: one blank or tab, or several."""
DELIMITERS = (";", "\t", ",", "|", BLANKS)
"""The likeliest first."""

# So many lines of data show the delimiter, so many rows the layout.
_LINES_JUDGED, _ROWS_JUDGED = 40, 120
_LONGEST_QUOTED = 8  # lines of one quoted name; more is a quotation mark that was never closed
# What programs on Japanese, Chinese and Korean Windows write.
_OF_SIGNS = ("cp932", "gb18030", "cp949", "big5")
# What those of Europe write, and an older Macintosh; where nothing decides, the first.
_OF_LETTERS = ("cp1252", "cp1250", "cp1251", "cp1254", "cp1253", "mac_roman")
_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32"),  # before that of UTF-16, with which it begins
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_APART = re.compile(r"[ \t]{2,}|\t")
_BEFORE_UNIT = re.compile(r"[ \t]+(?![\[(])")
_NUMBERS_APART = re.compile(r"[\d.,\w] [ \t]*[-+.,\d]|\t +[-+.,\d]")
_IN_QUOTES = re.compile(r'"[^"\n]*"')


@dataclass(frozen=True)
class TextLayout:
    """How a text file holds a table."""

    encoding: str
    """Of the file."""
    delimiter: str
    """Between cells; `BLANKS` stands for one or more."""
    rows: Layout
    """How its rows are laid out."""
    header_line: int
    """The number of the line with the names, from 1; 0 without a header."""
    first_data_line: int
    """The number of the first line that can hold data, from 1."""
    section: str = ""
    """The name of the table in the text, which a line that holds nothing ends; "" where the text is one table."""

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns, in order."""
        return self.rows.columns

    @property
    def header_place(self) -> str:
        """The line with the names, for messages; that of the first data where there is none."""
        return f"line {self.header_line or self.first_data_line}"

    def split(self, line: str, strict: bool = False) -> list[str]:
        """Return the cells of one line of data, without the blanks around them, those that it leaves out as empty.

        Parameters
        ----------
        strict : raise `csv.Error` for stray quotation marks.
        """
        if self.delimiter == BLANKS:
            cells = cells_between_blanks(line)
        else:
            # Blanks as the parser defines them: no-break spaces and the like belong to the cell.
            cells = [
                cell.strip(" \t") for row in csv.reader([line], delimiter=self.delimiter, strict=strict) for cell in row
            ] or [""]
        missing = len(self.columns) - len(cells)
        return cells + [""] * missing if missing > 0 and len(cells) == self.rows.shortest else cells

    def is_number(self, cell: str) -> bool:
        """Return True for a number with this file's decimal mark."""
        return number(cell, self.rows.decimal, self.rows.thousands) is not None


def encoding_of(content: bytes) -> str:
    """Return the encoding of a text by its first bytes: UTF-8, UTF-16 or UTF-32 where they are, else a code page.

    One of Windows of Japan, China or Korea, of another part of Europe or of an older Macintosh, where words of a header
    come out so, else the one of Western Europe.

    Parameters
    ----------
    content : from the beginning of the file; it may end within a character.

    Examples
    --------
    >>> encoding_of("Kräfte".encode()), encoding_of("Kräfte".encode("cp1252")), encoding_of("Fx".encode("utf-16"))
    ('utf-8', 'cp1252', 'utf-16')
    """
    for mark, encoding in _BOMS:
        if content.startswith(mark):
            return encoding
    zeros, most = [content[k:400:4].count(0) for k in range(4)], min(len(content), 400) // 4
    # two bytes of four are zero in each character of a language in use
    for order, pair in (("le", zeros[2:]), ("be", zeros[:2])):
        if 0 < most == min(pair) and sum(zeros) < 4 * most:
            return f"utf-32-{order}"
    odd, even = content[1:200:2].count(0), content[:200:2].count(0)
    if max(odd, even) > 20 * min(odd, even) and max(odd, even) * 4 >= min(len(content), 200):
        return "utf-16-le" if odd > even else "utf-16-be"
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        decoder.decode(content, final=False)
    except UnicodeDecodeError:
        for encodings, words in ((_OF_SIGNS, WORDS_OF_SIGNS), (_OF_LETTERS, WORDS_OF_LETTERS)):
            found = {encoding: _words_in(content, encoding, words) for encoding in encodings}
            if any(found.values()):
                return max(found, key=found.__getitem__)
        try:
            content.decode("cp1252")
        except UnicodeDecodeError:
            return "latin-1"
        return "cp1252"
    return "utf-8"


def _words_in(content: bytes, encoding: str, words: Sequence[str]) -> int:
    """Return how many of these words a text's beginning holds in an encoding; 0 where it is not written in it."""
    try:
        text = codecs.getincrementaldecoder(encoding)().decode(content, final=False)
    except UnicodeDecodeError:
        return 0
    small = text.lower()
    return sum(word in small for word in words)


@lru_cache(maxsize=1)  # of a small log it takes most of the time, and its header is looked at before its rows
def text_layout(
    text: str,
    encoding: str,
    *,
    delimiter: str | None = None,
    decimal: str | None = None,
    skip_rows: int | None = None,
    unit_row: bool | None = None,
    wanted: tuple[str, ...] = (),
) -> TextLayout:
    r"""Return how a text holds a table, by its first lines.

    Parameters
    ----------
    text : whole lines from the beginning, separated by line feeds. encoding : of the file.
    delimiter, decimal, skip_rows, unit_row : what is known of it.
    wanted : names of columns that are expected.

    Examples
    --------
    >>> found = text_layout("# t Fx\n 0.0  1.5\n 0.1  2.5\n", "utf-8")
    >>> found.delimiter, found.rows.columns, found.first_data_line
    (' ', ('t', 'Fx'), 2)
    """
    lines = text.split("\n")
    chosen = delimiter if delimiter is not None else _delimiter(lines, wanted, skip_rows, decimal)
    rows, last_lines = rows_of_lines(lines[skip_rows or 0 :][:_ROWS_JUDGED], chosen)
    if chosen == BLANKS:
        _join_names(rows, lines[skip_rows or 0 :])
    _part_names(rows, chosen)
    header = next((k for k, row in enumerate(rows) if any(row)), None) if skip_rows is not None else None
    layout = layout_of_rows(rows, wanted=wanted, header_row=header, unit_row=unit_row, decimal=decimal)
    before = skip_rows or 0

    def line_of(row: int) -> int:
        return before + (last_lines[row] if row < len(last_lines) else len(last_lines))

    first = before + (last_lines[layout.first_data_row - 1] if layout.first_data_row else 0) + 1
    header_line = 0 if layout.header_row is None else line_of(layout.header_row)
    return TextLayout(encoding, chosen, layout, header_line, first)


def rows_of_lines(lines: Sequence[str], delimiter: str) -> tuple[list[list[str]], list[int]]:
    """Return lines as rows of cells without blanks around them, and the number of the last line of each, from 1.

    A name in quotation marks may take several lines.
    """
    if delimiter == BLANKS:
        return [cells_between_blanks(line) for line in lines], list(range(1, len(lines) + 1))
    rows: list[list[str]] = []
    ends: list[int] = []
    try:
        reader = csv.reader([f"{line}\n" for line in lines], delimiter=delimiter)
        for row in reader:
            rows.append([" ".join(cell.split("\n")).strip(" \t\r") for cell in row])
            ends.append(reader.line_num)
    except csv.Error:
        rows, ends = [], [len(lines) + _LONGEST_QUOTED]
    if not ends or max(b - a for a, b in zip([0, *ends], ends, strict=False)) <= _LONGEST_QUOTED:
        return rows, ends
    return [[cell.strip(" \t\r") for cell in _split(line, delimiter)] for line in lines], list(range(1, len(lines) + 1))


def cells_between_blanks(line: str) -> list[str]:
    """Return the cells of a line that stand apart by blanks; what is in quotation marks stays together."""
    if '"' not in line:
        return line.split()
    return next(csv.reader([" ".join(_quoted_words(line))], delimiter=BLANKS), [])


def _quoted_words(line: str) -> list[str]:
    kept = [match[0] for match in _IN_QUOTES.finditer(line)]
    words = _IN_QUOTES.sub('"', line).split()
    return [word.replace('"', kept.pop(0), 1) if '"' in word and kept else word for word in words]


def _split(line: str, delimiter: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:
        return line.split(delimiter)


def _join_names(rows: list[list[str]], lines: Sequence[str]) -> None:
    """Put together names that hold blanks themselves, in rows of words above numbers of another count."""
    for k in range(min(_LINES_JUDGED, len(rows) - 1)):
        below = rows[k + 1]
        if len(rows[k]) > len(below) > 1 and is_number_row(below) and not is_number_row(rows[k]):
            rows[k] = _names_between_blanks(lines[k], len(below)) or rows[k]


def _part_names(rows: list[list[str]], delimiter: str) -> None:
    """Part names that stand apart by another sign than the numbers below them, as those that a person wrote on top."""
    for k in range(min(_LINES_JUDGED, len(rows) - 1)):
        below = rows[k + 1]
        if len(below) < 2 or not is_number_row(below) or is_number_row(rows[k]):
            continue
        line = " ".join(rows[k])
        others = [other for other in DELIMITERS if other not in (delimiter, BLANKS) and other in line]
        parted = [[name.strip() for name in without_comment_sign(_split(line, other), 0)] for other in others]
        found = next((names for names in parted if len(names) == len(below) and all(names)), None)
        if found is not None and (len(rows[k]) != len(below) or delimiter == BLANKS):
            rows[k] = found


def is_number_row(row: Sequence[str]) -> bool:
    """Return whether a row holds a number, with either decimal mark."""
    return any(is_reading(cell, mark, "") for cell in row for mark in ".,")


def _names_between_blanks(line: str, width: int) -> list[str] | None:
    """Return names that hold blanks themselves, where that gives as many as there are columns; None otherwise.

    Names stand apart by several blanks, or a unit in brackets stands one blank behind its name.

    Examples
    --------
    >>> _names_between_blanks("# t [s] Fx [N]", 2), _names_between_blanks("Time   Force x", 2)
    (['t [s]', 'Fx [N]'], ['Time', 'Force x'])
    """
    bare = line.strip()
    for sign in ("#", "%", "//"):
        bare = bare.removeprefix(sign).strip()
    if len(bare.split()) == width:
        return None
    for pattern in (_APART, _BEFORE_UNIT):
        names = pattern.split(bare)
        if len(names) == width:
            return names
    return None


def _delimiter(lines: Sequence[str], wanted: Collection[str], skip_rows: int | None, decimal: str | None) -> str:
    """Return what cuts the lines of data into most cells that are numbers, under a header of as many names."""
    judged = [line for line in lines if line.strip()][:_ROWS_JUDGED]
    below = judged[-max(3, min(_LINES_JUDGED, len(judged) // 2)) :]
    present = "".join(judged)
    apart = sum(1 for line in below if _NUMBERS_APART.search(line))
    best, merit = "", (False, 0.0, 0, 0)
    for candidate in DELIMITERS:
        if candidate not in present or (candidate == BLANKS and 2 * apart < len(below)):
            continue
        own = _merit(judged, below, candidate, wanted, decimal)
        if own > merit:
            best, merit = candidate, own
    return best or ("," if decimal != "," else ";")


def _merit(
    judged: Sequence[str], below: Sequence[str], delimiter: str, wanted: Collection[str], decimal: str | None
) -> tuple[bool, float, int, int]:
    """Return what speaks for a delimiter: wanted names, share of the text that is numbers, a header as wide, cells.

    A header of just as many names speaks for it more than a wider one: blanks cut dates into two, and units off names.
    Text rather than cells: a date that blanks cut into two would count twice.
    """
    rows, _ = rows_of_lines(below, delimiter)
    names, _ = rows_of_lines(judged[: _LINES_JUDGED + 1], delimiter)
    _part_names(names, delimiter)
    held = bool(wanted) and any(set(wanted) <= set(without_comment_sign(row, 0)) for row in names)
    mark, thousands = marks_of(cell for row in rows for cell in row)
    mark = decimal or mark
    counts = Counter(len(row) for row in rows if any(is_reading(cell, mark, thousands) for cell in row))
    width = max(counts, key=lambda own: (counts[own], own)) if counts else max(map(len, rows), default=0)
    filled = [cell for row in rows if len(row) == width for cell in row if cell]
    numbers = sum(len(cell) for cell in filled if is_reading(cell, mark, thousands) or is_gap(cell))
    share = numbers / max(1, sum(len(cell) for row in rows for cell in row))
    of_words = [row for row in names if not any(is_reading(cell, mark, thousands) for cell in row)]
    as_wide = max((1 + (len(row) == width) for row in of_words if len(row) >= width), default=0)
    return held, round(share, 2), as_wide, width
